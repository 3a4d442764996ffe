//! Between Godot's types and the core's.

use std::path::PathBuf;

use godot::classes::ProjectSettings;
use godot::prelude::*;
use lumivox_core::color::{linear_from_srgb, srgb_from_linear};
use lumivox_core::glam::{DAffine3, DMat3, DMat4, DVec3, DVec4};

/// A vector in Godot's precision.
pub fn vector(v: DVec3) -> Vector3 {
    Vector3::new(v.x as f32, v.y as f32, v.z as f32)
}

/// A vector in the core's precision.
pub fn dvec(v: Vector3) -> DVec3 {
    DVec3::new(f64::from(v.x), f64::from(v.y), f64::from(v.z))
}

/// An affine map in the core's precision.
pub fn affine(transform: Transform3D) -> DAffine3 {
    let columns = transform.basis.to_cols().map(dvec);
    let matrix = DMat3::from_cols(columns[0], columns[1], columns[2]);
    DAffine3::from_mat3_translation(matrix, dvec(transform.origin))
}

/// A projection in the core's precision.
pub fn matrix(projection: Projection) -> DMat4 {
    let [x, y, z, w] = projection.cols.map(|c| DVec4::new(c.x.into(), c.y.into(), c.z.into(), c.w.into()));
    DMat4::from_cols(x, y, z, w)
}

/// An affine map in Godot's precision.
pub fn transform(map: DAffine3) -> Transform3D {
    let columns = [map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis].map(vector);
    Transform3D::new(Basis::from_cols(columns[0], columns[1], columns[2]), vector(map.translation))
}

/// Whether two places are the same but for how the engine rounds: it makes some nodes' axes perpendicular once more.
pub fn is_same_place(a: Transform3D, b: Transform3D) -> bool {
    const ROUNDED: f32 = 1e-6;
    let near = |(a, b): (Vector3, Vector3)| (a - b).length() <= ROUNDED * a.length().max(b.length());
    a.origin == b.origin && a.basis.to_cols().into_iter().zip(b.basis.to_cols()).all(near)
}

/// An affine map's numbers: columns of the linear part, then the translation.
pub fn numbers(map: DAffine3) -> PackedFloat64Array {
    map.matrix3.to_cols_array().into_iter().chain(map.translation.to_array()).collect()
}

/// The way back; `None` if these are not the numbers of one.
pub fn affine_of(numbers: &[f64]) -> Option<DAffine3> {
    let numbers: &[f64; 12] = numbers.try_into().ok()?;
    let column = |i: usize| DVec3::from_slice(&numbers[3 * i..]);
    Some(DAffine3::from_mat3_translation(DMat3::from_cols(column(0), column(1), column(2)), column(3)))
}

/// Linear RGB of a colour, which Godot keeps in sRGB.
pub fn linear_from_color(color: Color) -> [f64; 3] {
    [color.r, color.g, color.b].map(|code| linear_from_srgb(f64::from(code)))
}

/// The colour of linear RGB.
pub fn color_from_linear(linear: [f64; 3]) -> Color {
    let [r, g, b] = linear.map(|c| srgb_from_linear(c) as f32);
    Color::from_rgb(r, g, b)
}

/// The path that the operating system knows, of one that may begin with `res://` or `user://`.
pub fn system_path(path: &GString) -> PathBuf {
    PathBuf::from(ProjectSettings::singleton().globalize_path(path).to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_come_back() {
        for linear in [[0.0, 0.001, 0.18], [0.5, 0.9, 1.0]] {
            let back = linear_from_color(color_from_linear(linear));
            for (a, b) in linear.into_iter().zip(back) {
                assert!((a - b).abs() < 1e-6, "{a} came back as {b}");
            }
        }
    }

    #[test]
    fn maps_keep_rows_and_columns_apart() {
        let map = DAffine3::from_mat3_translation(
            DMat3::from_cols_array(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0]),
            DVec3::new(11.0, 12.0, 13.0),
        );
        let there = transform(map);
        let point = DVec3::new(1.0, -2.0, 3.0);
        assert_eq!(dvec(there * vector(point)), map.transform_point3(point));
        assert_eq!(affine(there), map);
    }
}
