//! Names beside a picture: apart, within their columns, by lines that do not cross.

use eframe::egui::{Pos2, Rect, pos2};
use lumivox_studio::leaders::{Place, Point, places};

const COLUMNS: [Rect; 2] = [
    Rect { min: pos2(0.0, 20.0), max: pos2(90.0, 180.0) },
    Rect { min: pos2(310.0, 20.0), max: pos2(400.0, 120.0) },
];
const HEIGHT: f32 = 16.0;

/// Whether two lines cross within both.
fn cross([a, b]: [Pos2; 2], [c, d]: [Pos2; 2]) -> bool {
    let side = |p: Pos2, q: Pos2, r: Pos2| (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}

/// Points that lie about as chance has it, the same in every run.
fn scattered(count: usize, seed: u32) -> Vec<Point> {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    (0..count)
        .map(|_| Point { at: pos2(100.0 + 200.0 * next(), 200.0 * next()), weight: f64::from(next()) })
        .collect()
}

#[test]
fn no_two_names_overlap_nor_do_their_lines_cross() {
    for (count, seed) in (1..24).flat_map(|count| (0..40).map(move |seed| (count, seed))) {
        let points = scattered(count, seed);
        let placed = places(&points, COLUMNS, HEIGHT);
        // Ten lines of text at the left and six at the right.
        assert_eq!(placed.len(), count.min(16));
        for (is_left, column) in [(true, COLUMNS[0]), (false, COLUMNS[1])] {
            let own: Vec<&Place> = placed.iter().filter(|place| place.is_left == is_left).collect();
            let edge = if is_left { column.right() } else { column.left() };
            for (i, a) in own.iter().enumerate() {
                assert!(a.y - 0.5 * HEIGHT > column.top() - 0.01);
                assert!(a.y + 0.5 * HEIGHT < column.bottom() + 0.01);
                for b in &own[i + 1..] {
                    assert!((a.y - b.y).abs() > HEIGHT - 0.01, "{count} {seed}: {own:?}");
                    let line = |place: &Place| [pos2(edge, place.y), points[place.point].at];
                    assert!(!cross(line(a), line(b)), "{count} {seed}: {own:?}");
                }
            }
        }
    }
}

#[test]
fn names_stand_beside_their_points_where_there_is_room() {
    let point = |x: f32, y: f32| Point { at: pos2(x, y), weight: 1.0 };
    let placed = places(&[point(120.0, 60.0), point(280.0, 90.0), point(150.0, 140.0)], COLUMNS, HEIGHT);
    let place = |point: usize, is_left: bool, y: f32| Place { point, is_left, y };
    assert_eq!(placed, [place(0, true, 60.0), place(2, true, 140.0), place(1, false, 90.0)]);
    // Two at one height share it.
    let placed = places(&[point(120.0, 60.0), point(130.0, 60.0)], COLUMNS, HEIGHT);
    let ys: Vec<f32> = placed.iter().map(|place| place.y).collect();
    assert_eq!(ys, [52.0, 68.0]);
}

#[test]
fn where_there_is_no_room_for_all_the_largest_are_named() {
    let points: Vec<Point> =
        (0..40).map(|i| Point { at: pos2(200.0, 100.0), weight: f64::from(i) }).collect();
    let mut named: Vec<usize> = places(&points, COLUMNS, HEIGHT).iter().map(|place| place.point).collect();
    named.sort_unstable();
    assert_eq!(named, (24..40).collect::<Vec<_>>());
    let none = [Rect::from_min_max(pos2(0.0, 20.0), pos2(90.0, 25.0)); 2];
    assert_eq!(places(&points, none, HEIGHT), []);
}
