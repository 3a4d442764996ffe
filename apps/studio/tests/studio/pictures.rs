//! What leaves the program: scenes and pictures, which the command makes of them, too.

use std::ops::ControlFlow;

use lumivox_core::document::Backdrop;
use lumivox_renderer::{DisplaySettings, display};
use lumivox_scene::{Opening, Silent};
use lumivox_wgpu::{Gpu, RenderRequest, render};

use super::*;

/// What `lumivox render SCENE` makes of a scene, by the same crates.
fn rendered(file: &Path) -> ([u32; 2], Vec<u8>) {
    let written = lumivox_scene::read(file).unwrap();
    let cancel = CancelToken::new();
    let opened =
        lumivox_scene::open(&written.document, written.folder(), &Opening::default(), &Silent, &cancel);
    let lumivox_scene::Opened { scene, camera } = opened.unwrap();
    let film = written.document.film;
    let request = RenderRequest::new(film.size[0], film.size[1], film.samples.unwrap()).with(|it| {
        it.seed = film.seed;
        it.guides = film.denoise;
    });
    let name = std::env::var("LUMIVOX_GPU").ok();
    let mut gpu = Gpu::open(name.as_deref()).unwrap();
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    let traced = render(&mut gpu, &scene, &camera, &request, go_on).unwrap().film;
    let shown = DisplaySettings::from(&written.document.display);
    let mut rgba = shown.pixels(&traced, &scene.environment, &camera).into_flattened();
    if let Backdrop::Color(color) = written.document.display.background {
        display::put_on(&mut rgba, color);
    }
    (film.size, rgba)
}

fn decoded(file: &Path) -> ([u32; 2], Vec<u8>, Vec<String>) {
    let mut reader =
        png::Decoder::new(std::io::BufReader::new(std::fs::File::open(file).unwrap())).read_info().unwrap();
    let mut rgba = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut rgba).unwrap();
    let info = reader.info();
    let words = info.uncompressed_latin1_text.iter().map(|chunk| chunk.text.clone()).collect();
    ([info.width, info.height], rgba, words)
}

#[test]
fn a_saved_scene_is_the_exported_picture_and_comes_back() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let scan = head(folder.path(), 32);
    let (mut studio, answers) = studio();
    open(&mut studio, &[&scan]);
    click(&mut studio, "Bone");
    // A small picture, of few samples, turned.
    click(&mut studio, "Left");
    studio.state_mut().state.change(lumivox_studio::words::Word::Picture, |document| {
        (document.film.size, document.film.samples) = ([96, 64], Some(12));
        document.display.exposure = 0.7;
    });
    settle(&mut studio);
    click(&mut studio, "Export picture…");
    screenshot(&mut studio, "13-export");
    let picture = folder.path().join("picture.png");
    // The ending is added where it was left out.
    answers.next(folder.path().join("picture"));
    click(&mut studio, "Save as PNG…");
    settle(&mut studio);
    assert!(says(&studio, "Saved: picture.png"), "{:?}", texts(&studio));
    let scene = folder.path().join("view.lumivox");
    answers.next(&scene);
    click(&mut studio, "Save scene…");
    settle(&mut studio);
    assert!(!session(&studio).is_changed());

    let (size, wanted) = rendered(&scene);
    let (found_size, found, words) = decoded(&picture);
    assert_eq!((size, found_size), ([96, 64], [96, 64]));
    assert!(found == wanted, "the command's pixels");
    assert!(found.chunks_exact(4).any(|pixel| pixel != &found[..4]), "something is seen");
    assert!(words.iter().any(|text| text.contains("Not a medical device")));
    // Neither file says whose it is, and the scene finds its scan beside it.
    let text = std::fs::read_to_string(&scene).unwrap();
    assert!(!text.contains("Doe") && text.contains("\"scan\""), "{text}");

    // It comes back as it was.
    let document = session(&studio).document().clone();
    let (mut again, _) = super::studio();
    open(&mut again, &[&scene]);
    assert_eq!(again.state().state.failed, None);
    let back = again.state().state.session.as_ref().unwrap();
    assert_eq!(back.document().display, document.display);
    assert_eq!(back.document().volumes[0].look, document.volumes[0].look);
    assert_eq!(back.document().film, document.film);
    assert!(
        (back.camera().world_from_camera.translation
            - session(&studio).camera().world_from_camera.translation)
            .length()
            < 1e-9
    );
    assert_eq!(again.state().state.strip.thumbnails.len(), 1);
}
