//! A symmetric 2 × 2 weight as files write it.

use dem_model::Scalar;
use nalgebra::Matrix2;

/// A 2 × 2 symmetric weight. Whether it is symmetric and positive definite is checked by
/// [`Synthesis::new`](crate::Synthesis::new).
///
/// With the feature `serde`: `[a, b]` or `[[a, c], [c, b]]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SymmetricWeight {
    /// diag(a, b).
    Diagonal([f64; 2]),
    /// The matrix, row by row.
    Full([[f64; 2]; 2]),
}

impl SymmetricWeight {
    /// The weight as a matrix.
    pub fn matrix<T: Scalar>(&self) -> Matrix2<T> {
        let [[a, b], [c, d]] = match *self {
            Self::Diagonal([first, second]) => [[first, 0.0], [0.0, second]],
            Self::Full(rows) => rows,
        };
        Matrix2::new(T::constant(a), T::constant(b), T::constant(c), T::constant(d))
    }
}

/// By hand: serde's untagged enums need a heap.
#[cfg(feature = "serde")]
mod serialisation {
    use super::SymmetricWeight;
    use core::fmt;
    use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};
    use serde::ser::{Serialize, Serializer};

    const EXPECTED: &str = "a diagonal [a, b] or a symmetric matrix [[a, c], [c, b]] of numbers";

    impl Serialize for SymmetricWeight {
        fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
            match self {
                Self::Diagonal(diagonal) => diagonal.serialize(serializer),
                Self::Full(rows) => rows.serialize(serializer),
            }
        }
    }

    /// An element of the outer list.
    enum Element {
        Number(f64),
        Row([f64; 2]),
    }

    fn pair<'de, A: SeqAccess<'de>, E: Deserialize<'de>>(mut list: A) -> Result<[E; 2], A::Error> {
        let wrong = || A::Error::custom(format_args!("expected {EXPECTED}"));
        let first = list.next_element()?.ok_or_else(wrong)?;
        let second = list.next_element()?.ok_or_else(wrong)?;
        match list.next_element::<serde::de::IgnoredAny>()? {
            None => Ok([first, second]),
            Some(_) => Err(wrong()),
        }
    }

    impl<'de> Deserialize<'de> for Element {
        fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
            struct ElementVisitor;

            impl<'de> Visitor<'de> for ElementVisitor {
                type Value = Element;

                fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                    formatter.write_str(EXPECTED)
                }

                fn visit_f64<E: Error>(self, value: f64) -> Result<Element, E> {
                    Ok(Element::Number(value))
                }

                #[allow(clippy::as_conversions)] // As serde reads whole numbers into f64.
                fn visit_i64<E: Error>(self, value: i64) -> Result<Element, E> {
                    Ok(Element::Number(value as f64))
                }

                #[allow(clippy::as_conversions)] // As serde reads whole numbers into f64.
                fn visit_u64<E: Error>(self, value: u64) -> Result<Element, E> {
                    Ok(Element::Number(value as f64))
                }

                fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Element, A::Error> {
                    pair(list).map(Element::Row)
                }
            }

            deserializer.deserialize_any(ElementVisitor)
        }
    }

    impl<'de> Deserialize<'de> for SymmetricWeight {
        fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
            struct WeightVisitor;

            impl<'de> Visitor<'de> for WeightVisitor {
                type Value = SymmetricWeight;

                fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                    formatter.write_str(EXPECTED)
                }

                fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<SymmetricWeight, A::Error> {
                    match pair(list)? {
                        [Element::Number(a), Element::Number(b)] => Ok(SymmetricWeight::Diagonal([a, b])),
                        [Element::Row(first), Element::Row(second)] => Ok(SymmetricWeight::Full([first, second])),
                        _ => Err(A::Error::custom(format_args!("expected {EXPECTED}"))),
                    }
                }
            }

            deserializer.deserialize_seq(WeightVisitor)
        }
    }
}
