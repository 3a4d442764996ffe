//! Labels: what they hide, how dense they are, and where they lie.

use std::sync::Arc;

use lumivox_core::glam::{DAffine3, DVec3};
use lumivox_core::{Label, LabelStyle, LabelVolume, Labelling};
use lumivox_renderer::Film;
use lumivox_testing::scenes;
use lumivox_wgpu::RenderRequest;

use crate::film;

/// A label's own density counts where the medium has none.
#[test]
fn densities_of_labels_need_none_of_the_medium() {
    let with = |of_medium: f64| {
        let mut test = scenes::labels();
        let instance = &mut test.scene.volumes[0];
        let before = std::mem::replace(&mut instance.medium.density_scale, of_medium);
        let labelling = instance.labels.as_mut().expect("labels");
        for value in 0..=9 {
            let own = if value == 5 { 0.5 * before } else { before };
            labelling.set_style(value, LabelStyle { density_scale: Some(own), ..labelling.style(value) });
        }
        (film(&test, &RenderRequest::new(24, 24, 4)), before)
    };
    let (film, of_medium) = with(0.0);
    let (expected, _) = with(of_medium);
    assert!((0..24 * 24).any(|pixel| expected.alpha(pixel) > 0.5), "there is something to see");
    assert_eq!(film, expected);
}

/// A label has all of the scan where it has all voxels, the outer halves of the outermost included; of another grid than
/// the scan's, too.
#[test]
fn what_is_hidden_is_hidden_up_to_the_faces_of_the_scan() {
    let mut test = scenes::homogeneous_cube();
    let volume = test.scene.volumes[0].volume.clone();
    let [nx, ny, nz] = volume.dims();
    for factor in [1, 2, 3] {
        let dims = [nx / factor, ny / factor, nz / factor];
        let scale = factor as f64;
        let of_first = DVec3::splat((scale - 1.0) / 2.0);
        let place = volume.patient_from_voxel()
            * DAffine3::from_translation(of_first)
            * DAffine3::from_scale(DVec3::splat(scale));
        let body = Label { value: 1, name: "body".to_owned(), color: [0.5; 3] };
        let voxels = vec![1; dims.iter().product()];
        let labels = LabelVolume::new(dims, voxels, place, vec![body]).unwrap();
        let mut labelling = Labelling::new(Arc::new(labels));
        labelling.set_style(1, LabelStyle::hidden());
        test.scene.volumes[0].labels = Some(labelling);
        let film = film(&test, &RenderRequest::new(24, 24, 16));
        let seen: f64 = (0..24 * 24).map(|pixel| film.alpha(pixel)).sum();
        assert!(seen < 0.01, "{seen} pixels of a hidden body are seen, its voxels {factor} wide");
    }
}

/// Kernels know of labels that lie on the scan's own voxels, and map no point to them. Of those that lie a millionth beside it points are
/// mapped: by the same random numbers it is the same film, but where a point changes voxels by that.
#[test]
fn labels_on_the_scans_voxels_look_as_those_beside_them() {
    let with = |beside: f64| {
        let mut test = scenes::labels();
        let instance = &mut test.scene.volumes[0];
        let [nx, ny, nz] = instance.volume.dims();
        // Cubes of six voxels.
        let value =
            |i: usize| ([i % nx, i / nx % ny, i / (nx * ny)].map(|x| x / 6).iter().sum::<usize>() % 8) as u8;
        let named =
            (1..8).map(|value| Label { value, name: format!("cube {value}"), color: [0.5; 3] }).collect();
        let place = instance.volume.patient_from_voxel() * DAffine3::from_translation(DVec3::splat(beside));
        let labels = LabelVolume::new([nx, ny, nz], (0..nx * ny * nz).map(value).collect(), place, named);
        instance.labels.as_mut().expect("labels").labels = Arc::new(labels.expect("values of 0 to 7"));
        film(&test, &RenderRequest::new(24, 24, 16))
    };
    let (on, beside, shifted) = (with(0.0), with(3e-6), with(0.5));
    let others =
        |film: &Film| (0..24 * 24).filter(|&pixel| film.luminance(pixel) != on.luminance(pixel)).count();
    assert!((0..24 * 24).any(|pixel| on.alpha(pixel) > 0.5), "there is something to see");
    println!("{} and {} pixels differ", others(&beside), others(&shifted));
    assert!(others(&beside) < 24 * 24 / 20, "{} pixels differ", others(&beside));
    assert!(others(&shifted) > 24 * 24 / 4, "half a voxel is seen: {} pixels differ", others(&shifted));
}
