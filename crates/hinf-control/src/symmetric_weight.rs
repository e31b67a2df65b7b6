//! A symmetric weight as files write it.

use dem_model::Scalar;
use nalgebra::SMatrix;

/// An N × N symmetric weight. Whether it is symmetric and positive definite is checked by
/// [`Synthesis::new`](crate::Synthesis::new).
///
/// With the feature `serde`: `[a, b]` or `[[a, c], [c, b]]` for two joints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SymmetricWeight<const N: usize = 2> {
    /// diag(a, b, …).
    Diagonal([f64; N]),
    /// The matrix, row by row.
    Full([[f64; N]; N]),
}

impl<const N: usize> SymmetricWeight<N> {
    /// The weight as a matrix.
    pub fn matrix<T: Scalar>(&self) -> SMatrix<T, N, N> {
        let matrix = match *self {
            Self::Diagonal(diagonal) => SMatrix::from_diagonal(&diagonal.into()),
            // The rows are the columns of the transpose.
            Self::Full(rows) => SMatrix::<f64, N, N>::from(rows).transpose(),
        };
        matrix.map(T::constant)
    }
}

/// By hand: serde's untagged enums need a heap.
#[cfg(feature = "serde")]
mod serialisation {
    use super::SymmetricWeight;
    use core::fmt;
    use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};
    use serde::ser::{Serialize, Serializer};

    /// What a weight for `N` joints looks like.
    struct Expected<const N: usize>;

    impl<const N: usize> fmt::Display for Expected<N> {
        fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
            if N == 2 {
                formatter.write_str("a diagonal [a, b] or a symmetric matrix [[a, c], [c, b]] of numbers")
            } else {
                write!(formatter, "a diagonal of {N} numbers or a symmetric matrix of {N} rows of {N} numbers")
            }
        }
    }

    struct List<'a, S>(&'a [S]);

    impl<S: Serialize> Serialize for List<'_, S> {
        fn serialize<Z: Serializer>(&self, serializer: Z) -> Result<Z::Ok, Z::Error> {
            serializer.collect_seq(self.0)
        }
    }

    impl<const N: usize> Serialize for SymmetricWeight<N> {
        fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
            match self {
                Self::Diagonal(diagonal) => List(diagonal).serialize(serializer),
                Self::Full(rows) => List(&rows.each_ref().map(|row| List(row))).serialize(serializer),
            }
        }
    }

    /// An element of the outer list.
    #[derive(Clone, Copy)]
    enum Element<const N: usize> {
        Number(f64),
        Row([f64; N]),
    }

    /// Exactly `N` elements; `blank` is overwritten.
    fn elements<'de, A: SeqAccess<'de>, E: Deserialize<'de> + Copy, const N: usize>(
        mut list: A,
        blank: E,
    ) -> Result<[E; N], A::Error> {
        let wrong = || A::Error::custom(format_args!("expected {}", Expected::<N>));
        let mut elements = [blank; N];
        for element in &mut elements {
            *element = list.next_element()?.ok_or_else(wrong)?;
        }
        match list.next_element::<serde::de::IgnoredAny>()? {
            None => Ok(elements),
            Some(_) => Err(wrong()),
        }
    }

    impl<'de, const N: usize> Deserialize<'de> for Element<N> {
        fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
            struct ElementVisitor<const N: usize>;

            impl<'de, const N: usize> Visitor<'de> for ElementVisitor<N> {
                type Value = Element<N>;

                fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                    fmt::Display::fmt(&Expected::<N>, formatter)
                }

                fn visit_f64<E: Error>(self, value: f64) -> Result<Element<N>, E> {
                    Ok(Element::Number(value))
                }

                #[allow(clippy::as_conversions)] // As serde reads whole numbers into f64.
                fn visit_i64<E: Error>(self, value: i64) -> Result<Element<N>, E> {
                    Ok(Element::Number(value as f64))
                }

                #[allow(clippy::as_conversions)] // As serde reads whole numbers into f64.
                fn visit_u64<E: Error>(self, value: u64) -> Result<Element<N>, E> {
                    Ok(Element::Number(value as f64))
                }

                fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Element<N>, A::Error> {
                    elements(list, 0.0).map(Element::Row)
                }
            }

            deserializer.deserialize_any(ElementVisitor)
        }
    }

    impl<'de, const N: usize> Deserialize<'de> for SymmetricWeight<N> {
        fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
            struct WeightVisitor<const N: usize>;

            impl<'de, const N: usize> Visitor<'de> for WeightVisitor<N> {
                type Value = SymmetricWeight<N>;

                fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                    fmt::Display::fmt(&Expected::<N>, formatter)
                }

                fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<SymmetricWeight<N>, A::Error> {
                    let elements: [Element<N>; N] = elements(list, Element::Number(0.0))?;
                    let (mut numbers, mut rows, mut count) = ([0.0; N], [[0.0; N]; N], 0);
                    for ((number, row), element) in numbers.iter_mut().zip(&mut rows).zip(elements) {
                        match element {
                            Element::Number(found) => *number = found,
                            Element::Row(found) => (*row, count) = (found, count + 1),
                        }
                    }
                    match count {
                        0 => Ok(SymmetricWeight::Diagonal(numbers)),
                        rows_found if rows_found == N => Ok(SymmetricWeight::Full(rows)),
                        _ => Err(A::Error::custom(format_args!("expected {}", Expected::<N>))),
                    }
                }
            }

            deserializer.deserialize_seq(WeightVisitor)
        }
    }
}
