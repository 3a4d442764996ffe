//! Names beside a picture, each with a line to what it names: boundary labelling (Bekos et al., "Boundary labeling: models and
//! efficient algorithms for rectangular maps", Computational Geometry 36, 2007). Names stand in two columns, never over each
//! other, as near to the height of their points as that allows, and no two lines of a column cross.

use eframe::egui::{Pos2, Rect, pos2};

/// What is to be named.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Where it is seen.
    pub at: Pos2,
    /// How much of it is: where there is no room for all names, the largest have theirs.
    pub weight: f64,
}

/// Where a name stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Of which point, by its place in the list.
    pub point: usize,
    /// Whether it stands in the left column.
    pub is_left: bool,
    /// The middle of its line of text.
    pub y: f32,
}

/// Places for names of that height in two columns, where text may stand. Lines run from the columns' inner edges to the points.
pub fn places(points: &[Point], [left, right]: [Rect; 2], height: f32) -> Vec<Place> {
    let [room_left, room_right] = [left, right].map(|column| (column.height() / height).max(0.0) as usize);
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|a, b| points[*b].weight.total_cmp(&points[*a].weight).then(a.cmp(b)));
    order.truncate(room_left + room_right);
    // From left to right; half of the picture to each side, unless one is full.
    order.sort_by(|a, b| points[*a].at.x.total_cmp(&points[*b].at.x).then(a.cmp(b)));
    let middle = 0.5 * (left.left() + right.right());
    let wanted = order.iter().filter(|point| points[**point].at.x < middle).count();
    let count = wanted.clamp(order.len().saturating_sub(room_right), room_left.min(order.len()));
    let (to_left, to_right) = order.split_at(count);
    let own = |column: Rect, is_left: bool, members: &[usize]| {
        let edge = if is_left { column.right() } else { column.left() };
        let placed = column_of(points, members, [column.top(), column.bottom()], height, edge);
        placed.into_iter().map(move |(point, y)| Place { point, is_left, y }).collect::<Vec<_>>()
    };
    [own(left, true, to_left), own(right, false, to_right)].concat()
}

/// Heights in one column, whose lines begin at `edge`.
fn column_of(
    points: &[Point],
    members: &[usize],
    [top, bottom]: [f32; 2],
    height: f32,
    edge: f32,
) -> Vec<(usize, f32)> {
    let mut order = members.to_vec();
    order.sort_by(|a, b| points[*a].at.y.total_cmp(&points[*b].at.y).then(a.cmp(b)));
    let wanted: Vec<f32> = order.iter().map(|point| points[*point].at.y).collect();
    let ys = spread(&wanted, [top + 0.5 * height, bottom - 0.5 * height], height);
    // Two lines that cross are shorter the other way round, so that this ends.
    let mut swapped = true;
    while swapped {
        swapped = false;
        for i in 0..order.len() {
            for j in i + 1..order.len() {
                let line = |place: usize, point: usize| [pos2(edge, ys[place]), points[order[point]].at];
                let (own, other) = (line(i, i), line(j, j));
                let length = |[a, b]: [Pos2; 2]| a.distance(b);
                let (now, then) = (length(own) + length(other), length(line(i, j)) + length(line(j, i)));
                if cross(own, other) && then < now - 1e-3 {
                    order.swap(i, j);
                    swapped = true;
                }
            }
        }
    }
    order.into_iter().zip(ys).collect()
}

/// Heights at least so far apart and between two ends, of those the nearest to the wanted ones, which ascend, by the sum of squares:
/// isotonic regression by pooling adjacent violators (Barlow et al. 1972).
fn spread(wanted: &[f32], [low, high]: [f32; 2], apart: f32) -> Vec<f32> {
    // Without the room that each takes, they only have to ascend. Pools of what cannot, by their sum and count.
    let mut pools: Vec<(f32, usize)> = vec![];
    for (place, y) in wanted.iter().enumerate() {
        pools.push((y - place as f32 * apart, 1));
        while let [.., a, b] = pools[..]
            && a.0 / a.1 as f32 >= b.0 / b.1 as f32
        {
            pools.truncate(pools.len() - 2);
            pools.push((a.0 + b.0, a.1 + b.1));
        }
    }
    let highest = high - wanted.len().saturating_sub(1) as f32 * apart;
    let pooled = pools.into_iter().flat_map(|(sum, count)| std::iter::repeat_n(sum / count as f32, count));
    pooled.enumerate().map(|(place, y)| y.min(highest).max(low) + place as f32 * apart).collect()
}

/// Whether two lines cross within both.
fn cross([a, b]: [Pos2; 2], [c, d]: [Pos2; 2]) -> bool {
    let side = |p: Pos2, q: Pos2, r: Pos2| {
        let (to, other) = (q - p, r - p);
        to.x * other.y - to.y * other.x
    };
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}
