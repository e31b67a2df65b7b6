//! Curves as chains of straight pieces: cut at the axes, thinned, and dashed.

/// The parts of a chain of points that lie within a rectangle `[left, right] × [bottom, top]`.
pub fn clip(points: &[[f64; 2]], x: [f64; 2], y: [f64; 2]) -> Vec<Vec<[f64; 2]>> {
    let mut parts: Vec<Vec<[f64; 2]>> = Vec::new();
    for pair in points.windows(2) {
        let &[from, to] = pair else { continue };
        let Some([start, end]) = clip_segment(from, to, x, y) else { continue };
        match parts.last_mut() {
            Some(part) if part.last() == Some(&start) => part.push(end),
            _ => parts.push(vec![start, end]),
        }
    }
    parts
}

/// Liang and Barsky's clipping: the part of the line from parameter 0 to 1 that is inside all four borders.
fn clip_segment(from: [f64; 2], to: [f64; 2], x: [f64; 2], y: [f64; 2]) -> Option<[[f64; 2]; 2]> {
    let mut enter = 0.0_f64;
    let mut leave = 1.0_f64;
    for (start, end, [low, high]) in [(from[0], to[0], x), (from[1], to[1], y)] {
        let run = end - start;
        if run == 0.0 {
            if !(low..=high).contains(&start) {
                return None;
            }
            continue;
        }
        let (first, second) = ((low - start) / run, (high - start) / run);
        enter = enter.max(first.min(second));
        leave = leave.min(first.max(second));
    }
    let at = |s: f64| [from[0] + s * (to[0] - from[0]), from[1] + s * (to[1] - from[1])];
    // Points that are inside stay as they are, so that the parts of a chain meet exactly.
    let start = if enter == 0.0 { from } else { at(enter) };
    let end = if leave == 1.0 { to } else { at(leave) };
    (enter <= leave).then_some([start, end])
}

/// A chain with fewer points that stays within `tolerance` of the given one (Douglas and Peucker).
pub fn thin(points: &[[f64; 2]], tolerance: f64) -> Vec<[f64; 2]> {
    let (Some(&first), Some(&last)) = (points.first(), points.last()) else { return Vec::new() };
    let mut kept = vec![first];
    // Without recursion, so that no curve is too long for the stack.
    let mut pending = vec![(0, points.len() - 1)];
    while let Some((from, to)) = pending.pop() {
        let farthest = (from + 1..to)
            .map(|index| (index, distance(points[index], points[from], points[to])))
            .fold((from, tolerance), |best, candidate| if candidate.1 > best.1 { candidate } else { best });
        if farthest.0 > from {
            pending.push((farthest.0, to));
            pending.push((from, farthest.0));
        } else {
            kept.push(points[to]);
        }
    }
    if points.len() == 1 { vec![last] } else { kept }
}

/// The distance of `point` from the line piece between `from` and `to`.
pub fn distance(point: [f64; 2], from: [f64; 2], to: [f64; 2]) -> f64 {
    let along = [to[0] - from[0], to[1] - from[1]];
    let offset = [point[0] - from[0], point[1] - from[1]];
    let length_squared = along[0] * along[0] + along[1] * along[1];
    let projected = along[0] * offset[0] + along[1] * offset[1];
    let share = if length_squared > 0.0 { (projected / length_squared).clamp(0.0, 1.0) } else { 0.0 };
    let (x, y) = (offset[0] - share * along[0], offset[1] - share * along[1]);
    (x * x + y * y).sqrt()
}

/// The drawn pieces of a dashed chain; `pattern` holds the lengths drawn and left out in turn.
pub fn dash(points: &[[f64; 2]], pattern: &[f64]) -> Vec<Vec<[f64; 2]>> {
    if pattern.is_empty() || pattern.iter().any(|length| *length <= 0.0) {
        return vec![points.to_vec()];
    }
    let mut pieces = Vec::new();
    let mut piece: Vec<[f64; 2]> = points.first().copied().into_iter().collect();
    let (mut phase, mut remaining) = (0, pattern[0]);
    for pair in points.windows(2) {
        let &[mut from, to] = pair else { continue };
        loop {
            let length = ((to[0] - from[0]).powi(2) + (to[1] - from[1]).powi(2)).sqrt();
            if length < remaining {
                remaining -= length;
                // A chain that ends where a dash would begin has no dash there.
                if length > 0.0 {
                    piece.push(to);
                }
                break;
            }
            let share = remaining / length;
            from = [from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1])];
            piece.push(from);
            if phase % 2 == 0 {
                pieces.push(std::mem::take(&mut piece));
            }
            phase = (phase + 1) % (2 * pattern.len());
            remaining = pattern[phase % pattern.len()];
            piece = vec![from];
        }
    }
    if phase % 2 == 0 && piece.len() > 1 {
        pieces.push(piece);
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_is_cut_where_it_leaves_the_axes() {
        let parts = clip(&[[0.0, 0.0], [1.0, 2.0], [2.0, 0.0], [3.0, 0.5]], [0.0, 3.0], [0.0, 1.0]);
        assert_eq!(parts, [vec![[0.0, 0.0], [0.5, 1.0]], vec![[1.5, 1.0], [2.0, 0.0], [3.0, 0.5]]]);
    }

    #[test]
    fn dashes_have_the_lengths_of_the_pattern() {
        let pieces = dash(&[[0.0, 0.0], [4.0, 0.0], [10.0, 0.0]], &[3.0, 2.0]);
        assert_eq!(pieces, [vec![[0.0, 0.0], [3.0, 0.0]], vec![[5.0, 0.0], [8.0, 0.0]]]);
    }

    #[test]
    fn thinning_keeps_corners_and_stays_within_its_tolerance() {
        let wave: Vec<[f64; 2]> = (0..1000).map(|k| f64::from(k) * 0.01).map(|x| [x, x.sin()]).collect();
        let thinned = thin(&wave, 0.01);
        assert!(thinned.len() < 100, "{}", thinned.len());
        for point in &wave {
            let nearest =
                thinned.windows(2).map(|pair| distance(*point, pair[0], pair[1])).fold(f64::INFINITY, f64::min);
            assert!(nearest <= 0.01);
        }
        let corner = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]];
        assert_eq!(thin(&corner, 0.1), corner);
    }
}
