//! Lists in sentences.

/// As in "1, 2 and 3".
pub fn in_words(items: impl Iterator<Item = impl ToString>) -> String {
    let items: Vec<_> = items.map(|item| item.to_string()).collect();
    match items.split_last() {
        Some((last, [])) => last.clone(),
        Some((last, others)) => format!("{} and {last}", others.join(", ")),
        None => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_of_a_list_comes_after_an_and() {
        assert_eq!(in_words([1, 2, 3].iter()), "1, 2 and 3");
        assert_eq!(in_words(["a", "b"].iter()), "a and b");
        assert_eq!(in_words(["a"].iter()), "a");
        assert_eq!(in_words(std::iter::empty::<u8>()), "");
    }
}
