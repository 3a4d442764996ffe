//! Films: each frame that Movie Maker writes is done, as no later one makes up for it.

use std::fs;

use lumivox_testing::png_io::SrgbImage;

use crate::case::{Case, Light, Volume};
use crate::engine::engine;
use crate::shown::told;

#[test]
fn every_frame_of_a_film_has_all_its_samples() {
    const TARGET: u32 = 6;
    let engine = engine();
    let case = Case {
        size: [64, 48],
        samples: TARGET,
        // Far less than a frame takes.
        budget: 0.5,
        light: Light::Color([0.8; 3]),
        volumes: vec![Volume::solid()],
        ..Case::new("film")
    };
    let (folder, file) = engine.write_cases("film", &case);
    let frames = folder.join("frame.png");
    let [cases, frames] = [&file, &frames].map(|path| path.to_str().unwrap());
    let arguments = ["--write-movie", frames, "--fixed-fps", "10", "--resolution", "64x48"];
    let scene = ["res://tests/film.tscn", "--", "--cases", cases];
    let run = engine.run("film", &[&arguments[..], &scene[..]].concat());
    let told = told(&run, "film");
    println!("film: {told}");
    let samples = told["samples"].as_array().expect("a list");
    // The engine's sky may be there a frame later, and with it another image: that one is done, too.
    assert!(samples.iter().all(|one| one.as_u64() == Some(TARGET.into())), "{told}");
    let written: Vec<_> = fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "png"))
        .collect();
    assert!(written.len() >= samples.len(), "{written:?}");
    let brightest = |path| {
        let picture = SrgbImage::read(path).unwrap();
        picture.pixels.iter().flatten().copied().max()
    };
    assert!(written.iter().any(|path| brightest(path) > Some(60)), "the film shows nothing");
}
