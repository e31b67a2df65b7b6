//! Work on all cores.

use std::num::NonZeroUsize;
use std::thread;

use anyhow::Context;
use rayon::ThreadPoolBuilder;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

/// As many threads as the machine runs at once.
pub fn all_cores() -> NonZeroUsize {
    thread::available_parallelism().unwrap_or(NonZeroUsize::MIN)
}

/// `work(0), …, work(count − 1)`, done on `threads` threads. `done` is called after each, on any of them.
///
/// # Errors
/// One of those that `work` returned; what has not begun is left out then.
pub fn in_parallel<T: Send>(
    count: usize,
    threads: NonZeroUsize,
    work: impl Fn(usize) -> anyhow::Result<T> + Sync,
    done: impl Fn() + Sync,
) -> anyhow::Result<Vec<T>> {
    // More threads than work would only cost their making.
    let threads = threads.get().min(count.max(1));
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().context("threads")?;
    let one = |index| {
        let result = work(index)?;
        done();
        Ok(result)
    };
    pool.install(|| (0..count).into_par_iter().map(one).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn results_are_in_order_on_any_number_of_threads() {
        for threads in [1, 2, 7] {
            let finished = AtomicUsize::new(0);
            let count = || {
                finished.fetch_add(1, Ordering::Relaxed);
            };
            let threads = NonZeroUsize::new(threads).unwrap();
            let squares = in_parallel(100, threads, |index| Ok(index * index), count).unwrap();
            assert_eq!(squares, (0..100).map(|index| index * index).collect::<Vec<_>>());
            assert_eq!(finished.into_inner(), 100);
        }
        assert!(in_parallel(0, NonZeroUsize::MIN, |_| Ok(()), || ()).unwrap().is_empty());
    }

    #[test]
    fn an_error_ends_the_work() {
        let begun = AtomicUsize::new(0);
        let work = |index| {
            begun.fetch_add(1, Ordering::Relaxed);
            if index == 3 { Err(anyhow::anyhow!("three")) } else { Ok(()) }
        };
        assert_eq!(in_parallel(1000, NonZeroUsize::MIN, work, || ()).unwrap_err().to_string(), "three");
        assert!(begun.into_inner() < 1000);
    }
}
