//! A curve that comes point by point, in memory that does not grow with its length.

/// The most spans of a curve; there are fewer columns than half of it to draw in.
const MOST_SPANS: usize = 4096;

/// A curve as the least and the most of each span of neighbours. A span is one point until there are more than 4096; from then on
/// it has 2, 4, 8 points and so on, the same number in all but the last, so that 2048 to 4096 spans are kept.
#[derive(Clone, Debug)]
pub struct Envelope {
    spans: Vec<Span>,
    /// Points in each span but the last.
    length: usize,
    /// Points in the last span.
    in_last: usize,
}

/// The two extremes of neighbours, in the order in which they came.
#[derive(Clone, Copy, Debug)]
struct Span([[f64; 2]; 2]);

impl Span {
    /// This span and the one behind it.
    fn and(self, Self(later): Self) -> Self {
        let all = [self.0[0], self.0[1], later[0], later[1]];
        let (mut least, mut most) = (0, 0);
        for (index, [_, y]) in all.iter().enumerate() {
            if *y < all[least][1] {
                least = index;
            }
            if *y > all[most][1] {
                most = index;
            }
        }
        Self([all[least.min(most)], all[least.max(most)]])
    }
}

impl Default for Envelope {
    /// No points yet.
    fn default() -> Self {
        Self { spans: Vec::new(), length: 1, in_last: 0 }
    }
}

impl Envelope {
    /// Takes the next point `[x, y]`; one that is not finite is left out.
    pub fn take(&mut self, point: [f64; 2]) {
        if !point.iter().all(|value| value.is_finite()) {
            return;
        }
        let span = Span([point; 2]);
        match self.spans.last_mut() {
            Some(last) if self.in_last < self.length => {
                *last = last.and(span);
                self.in_last += 1;
            }
            _ => {
                if self.spans.len() == MOST_SPANS {
                    self.spans = self.spans.chunks_exact(2).map(|pair| pair[0].and(pair[1])).collect();
                    self.length *= 2;
                }
                self.spans.push(span);
                self.in_last = 1;
            }
        }
    }

    /// The points that are kept, in their order: every point of a short curve, of a long one at most 8192, the first of all least and
    /// the first of all largest values among them.
    pub fn points(&self) -> impl Iterator<Item = [f64; 2]> {
        self.spans.iter().flat_map(|Span([first, second])| {
            let is_one = first == second;
            [Some(*first), (!is_one).then_some(*second)].into_iter().flatten()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn envelope(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let mut envelope = Envelope::default();
        points.iter().for_each(|point| envelope.take(*point));
        envelope.points().collect()
    }

    #[test]
    fn a_short_curve_is_kept_as_it_is_but_for_what_is_not_finite() {
        let points: Vec<[f64; 2]> = (0..4096).map(|k| [f64::from(k), f64::from(k % 7)]).collect();
        assert_eq!(envelope(&points), points);
        assert_eq!(
            envelope(&[[0.0, 1.0], [1.0, f64::NAN], [f64::INFINITY, 1.0], [2.0, 3.0]]),
            [[0.0, 1.0], [2.0, 3.0]]
        );
    }

    /// A peak of one point in a million, a trough in another, wherever they stand in their spans.
    #[test]
    fn a_long_curve_keeps_every_extreme_in_bounded_memory() {
        for at in [0, 1, 4095, 4096, 65_535, 654_321, 999_999] {
            let value = |k: i32| {
                if k == at {
                    9.0
                } else if k == 999_999 - at {
                    -9.0
                } else {
                    f64::from(k % 3)
                }
            };
            let mut envelope = Envelope::default();
            (0..1_000_000).for_each(|k| envelope.take([f64::from(k), value(k)]));
            let points: Vec<_> = envelope.points().collect();
            assert!((4096..=8192).contains(&points.len()), "{}", points.len());
            assert!(envelope.spans.capacity() <= 2 * MOST_SPANS);
            assert!(
                points.contains(&[f64::from(at), 9.0]) && points.contains(&[f64::from(999_999 - at), -9.0]),
                "{at}"
            );
            assert!(points.is_sorted_by(|one, other| one[0] < other[0]));
        }
    }
}
