//! Numbers as CiA 306 writes them.

/// A decimal, hexadecimal (`0x`) or octal (leading `0`) number, with sign. `08` is decimal: it cannot be octal.
pub fn integer(text: &str) -> Option<i128> {
    let (sign, digits) = match text.strip_prefix('-') {
        Some(digits) => (-1, digits.trim_start()),
        None => (1, text.strip_prefix('+').unwrap_or(text)),
    };
    let magnitude = if let Some(digits) = digits.strip_prefix("0x").or_else(|| digits.strip_prefix("0X")) {
        unsigned(digits, 16)
    } else {
        let octal = digits.strip_prefix('0').filter(|rest| !rest.is_empty());
        octal.and_then(|digits| unsigned(digits, 8)).or_else(|| unsigned(digits, 10))
    }?;
    Some(sign * i128::from(magnitude))
}

/// Digits alone: what `from_str_radix` takes beyond them, such as a sign, is none.
fn unsigned(digits: &str, radix: u32) -> Option<u64> {
    let only_digits = digits.chars().all(|digit| digit.is_digit(radix));
    only_digits.then(|| u64::from_str_radix(digits, radix).ok()).flatten()
}

/// A number, or the node's id with a number added to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Expression {
    pub with_node: bool,
    pub offset: i128,
}

/// `0x180`, `$NODEID+0x180` or `0x180+$NODEID`, with spaces and in either case.
pub fn expression(text: &str) -> Option<Expression> {
    let is_node = |term: &str| term.eq_ignore_ascii_case("$NODEID");
    let fixed = |offset| Expression { with_node: false, offset };
    let with_node = |offset| Expression { with_node: true, offset };
    if is_node(text) {
        return Some(with_node(0));
    }
    match text.split_once('+') {
        Some((node, offset)) if is_node(node.trim()) => integer(offset.trim()).map(with_node),
        Some((offset, node)) if is_node(node.trim()) => integer(offset.trim()).map(with_node),
        _ => integer(text).map(fixed),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_bases_and_a_sign() {
        for (text, number) in [
            ("0", 0),
            ("0x7", 7),
            ("0x0007", 7),
            ("0XfF", 255),
            ("017", 15),
            ("08", 8),
            ("-2", -2),
            ("-0x80", -128),
            ("+5", 5),
            ("0xFFFFFFFFFFFFFFFF", i128::from(u64::MAX)),
        ] {
            assert_eq!(integer(text), Some(number), "{text}");
        }
        for text in ["", "-", "0x", "x", "1.5", "0x1G", "12 13", "--1", "0x-1", "99999999999999999999999"] {
            assert_eq!(integer(text), None, "{text}");
        }
    }

    #[test]
    fn the_node_is_added_in_either_order() {
        for text in ["$NODEID+0x180", "0x180+$NODEID", "$NodeID + 0x180", "0x180 + $nodeid"] {
            assert_eq!(expression(text), Some(Expression { with_node: true, offset: 0x180 }), "{text}");
        }
        assert_eq!(expression("$NODEID"), Some(Expression { with_node: true, offset: 0 }));
        assert_eq!(expression("0x180"), Some(Expression { with_node: false, offset: 0x180 }));
        assert_eq!(expression("$NODE+1"), None);
    }
}
