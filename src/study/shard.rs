//! A part of many experiments.

use std::str::FromStr;

/// Part `number` of `of`: experiments dealt out one by one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    number: u64,
    of: u64,
}

impl Shard {
    /// All of it.
    pub const WHOLE: Self = Self { number: 1, of: 1 };

    /// Part `number`, counted from 1, of `of`; `None` if there is no such part.
    pub fn new(number: u64, of: u64) -> Option<Self> {
        (1..=of).contains(&number).then_some(Self { number, of })
    }

    /// Those of the numbers `0..count` that are in this part.
    pub fn of(self, count: u64) -> impl Iterator<Item = u64> {
        let step = usize::try_from(self.of).unwrap_or(usize::MAX);
        (self.number - 1..count).step_by(step)
    }
}

impl FromStr for Shard {
    type Err = String;

    /// `2/8`: the second of eight.
    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('/').and_then(|(number, of)| Some((number.parse().ok()?, of.parse().ok()?)));
        let shard = parts.and_then(|(number, of)| Self::new(number, of));
        shard.ok_or_else(|| "expected PART/PARTS, counted from 1, such as 2/8".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_have_each_number_once() {
        let mut all: Vec<_> = (1..=3).flat_map(|number| Shard::new(number, 3).unwrap().of(10)).collect();
        all.sort_unstable();
        assert_eq!(all, (0..10).collect::<Vec<_>>());
        assert_eq!(Shard::new(2, 3).unwrap().of(10).collect::<Vec<_>>(), [1, 4, 7]);
        assert_eq!(Shard::WHOLE.of(3).collect::<Vec<_>>(), [0, 1, 2]);
        assert_eq!(Shard::new(3, 3).unwrap().of(2).count(), 0);
    }

    #[test]
    fn what_is_no_part_is_refused() {
        for text in ["", "0/3", "4/3", "1/0", "1", "a/b", "-1/3", "1/3/5"] {
            assert!(text.parse::<Shard>().is_err(), "{text}");
        }
        assert_eq!("2/8".parse(), Ok(Shard { number: 2, of: 8 }));
    }
}
