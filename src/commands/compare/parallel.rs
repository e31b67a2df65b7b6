//! Independent work on several threads, with results in order.

use std::num::NonZeroUsize;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// As many threads as the machine runs at once.
pub fn all_cores() -> NonZeroUsize {
    thread::available_parallelism().unwrap_or(NonZeroUsize::MIN)
}

/// `work(0), …, work(count − 1)`, done on `threads` threads. `done` is called after each, on any of them.
///
/// # Errors
/// One of those that `work` returned; what has not begun is left out then.
pub fn map<T: Send>(
    count: usize,
    threads: NonZeroUsize,
    work: impl Fn(usize) -> anyhow::Result<T> + Sync,
    done: impl Fn() + Sync,
) -> anyhow::Result<Vec<T>> {
    let next = AtomicUsize::new(0);
    let worker = || {
        let mut results = Vec::new();
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            if index >= count {
                return Ok(results);
            }
            match work(index) {
                Ok(result) => results.push((index, result)),
                Err(error) => {
                    next.store(count, Ordering::Relaxed);
                    return Err(error);
                }
            }
            done();
        }
    };
    let mut results = thread::scope(|scope| {
        let workers: Vec<_> = (0..threads.get().min(count)).map(|_| scope.spawn(worker)).collect();
        let mut results = Vec::with_capacity(count);
        for worker in workers {
            results.extend(worker.join().unwrap_or_else(|panic| resume_unwind(panic))?);
        }
        anyhow::Ok(results)
    })?;
    results.sort_unstable_by_key(|(index, _)| *index);
    Ok(results.into_iter().map(|(_, result)| result).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_in_order_on_any_number_of_threads() {
        for threads in [1, 2, 7] {
            let finished = AtomicUsize::new(0);
            let count = || {
                finished.fetch_add(1, Ordering::Relaxed);
            };
            let squares = map(100, NonZeroUsize::new(threads).unwrap(), |index| Ok(index * index), count).unwrap();
            assert_eq!(squares, (0..100).map(|index| index * index).collect::<Vec<_>>());
            assert_eq!(finished.into_inner(), 100);
        }
    }

    #[test]
    fn an_error_ends_the_work() {
        let begun = AtomicUsize::new(0);
        let work = |index| {
            begun.fetch_add(1, Ordering::Relaxed);
            if index == 3 { Err(anyhow::anyhow!("three")) } else { Ok(()) }
        };
        assert_eq!(map(1000, NonZeroUsize::MIN, work, || ()).unwrap_err().to_string(), "three");
        assert_eq!(begun.into_inner(), 4);
    }

    #[test]
    fn no_work_is_no_error() {
        assert_eq!(map(0, all_cores(), |_| Ok(()), || ()).unwrap(), []);
    }
}
