//! Films: each frame that Movie Maker writes is done, as no later one makes up for it.

use std::fs;
use std::path::{Path, PathBuf};

use lumivox_testing::png_io::SrgbImage;
use serde_json::Value;

use crate::case::{Case, Light, Volume};
use crate::engine::engine;
use crate::shown::told;

/// Writes a film of a volume that turns, by so many samples or until so much noise is left, on a budget far below what a frame
/// takes; returns its folder, and the samples of its frames.
fn film(name: &'static str, target: u32, noise: f64) -> (PathBuf, Vec<u64>) {
    let engine = engine();
    let case = Case {
        size: [64, 48],
        samples: target,
        budget: 0.5,
        light: Light::Color([0.8; 3]),
        volumes: vec![Volume::solid()],
        ..Case::new(name)
    };
    let (folder, file) = engine.write_cases(name, &case);
    let frames = folder.join("frame.png");
    let [cases, frames] = [&file, &frames].map(|path| path.to_str().unwrap());
    let arguments = ["--write-movie", frames, "--fixed-fps", "10", "--resolution", "64x48"];
    let noise = noise.to_string();
    let scene = ["res://tests/film.tscn", "--", "--cases", cases, "--noise", &noise];
    let run = engine.run(name, &[&arguments[..], &scene[..]].concat());
    let told = told(&run, "film");
    println!("{name}: {told}");
    let samples = told["samples"].as_array().expect("a list");
    (folder.clone(), samples.iter().filter_map(Value::as_u64).collect())
}

fn written(folder: &Path) -> Vec<PathBuf> {
    let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    files.filter(|path| path.extension().is_some_and(|e| e == "png")).collect()
}

#[test]
fn every_frame_of_a_film_has_all_its_samples() {
    const TARGET: u32 = 6;
    let (folder, samples) = film("film", TARGET, 0.0);
    // The engine's sky may be there a frame later, and with it another image: that one is done, too.
    assert!(samples.len() == 4 && samples.iter().all(|one| *one == u64::from(TARGET)), "{samples:?}");
    let written = written(&folder);
    assert!(written.len() >= samples.len(), "{written:?}");
    let brightest = |path: &PathBuf| {
        let picture = SrgbImage::read(path).unwrap();
        picture.pixels.iter().flatten().copied().max()
    };
    assert!(written.iter().any(|path| brightest(path) > Some(60)), "the film shows nothing");
}

#[test]
fn every_frame_of_a_film_ends_by_its_noise() {
    let (_, rough) = film("film_noise", 4096, 0.2);
    let (_, clean) = film("film_less_noise", 4096, 0.1);
    // 16 are the fewest that noise is known of; half of it takes four times the samples.
    assert!(rough.len() == 4 && rough.iter().all(|n| (16..512).contains(n)), "{rough:?}");
    assert!(clean.iter().zip(&rough).all(|(less, more)| less >= more && *less < 2048), "{clean:?} {rough:?}");
    assert!(clean.iter().sum::<u64>() > rough.iter().sum(), "{clean:?} {rough:?}");
}
