//! FLIP over the frames of a film, as SVG: a line for each cost and variant.

use std::fmt::Write;

use super::options::{Options, Variant};
use super::report::{Phase, Run};

const SIZE: [f64; 2] = [960.0, 420.0];

/// Left, top, right, bottom.
const MARGINS: [f64; 4] = [56.0, 40.0, 190.0, 44.0];

/// Of costs, from the dearest.
const COLORS: [&str; 6] = ["#1b6ca8", "#d1495b", "#3c9d5b", "#8a5aab", "#c98a1b", "#555555"];

/// Writes `plots/SCENE-LOOK-FILM.svg` into the folder.
pub fn write(options: &Options, runs: &[Run]) -> Result<(), String> {
    let Some(first) = runs.first() else { return Ok(()) };
    let folder = options.out.join("plots");
    let path = folder.join(format!("{}.svg", first.film_name()));
    let written = std::fs::create_dir_all(&folder).and_then(|()| std::fs::write(&path, svg(options, runs)));
    written.map_err(|error| format!("{}: {error}", path.display()))
}

fn svg(options: &Options, runs: &[Run]) -> String {
    let rest = options.rest.last().copied().unwrap_or(0);
    let frames = options.length + rest + options.after + 1;
    let place = |phase: Phase, frame: usize| match phase {
        Phase::Moving => frame,
        Phase::Rest => options.length - 1 + frame,
        Phase::Cut => options.length + rest + frame,
    };
    let points = |run: &Run| -> Vec<(Phase, usize, f64)> {
        let point = |shot: &super::Shot| Some((shot.phase, place(shot.phase, shot.frame), shot.judged.flip?));
        run.shots.iter().filter_map(point).collect()
    };
    let most = runs.iter().flat_map(points).map(|point| point.2).fold(0.05, f64::max);
    let top = (most * 20.0).ceil() / 20.0;
    let [left, above, right, below] = MARGINS;
    let inner = [SIZE[0] - left - right, SIZE[1] - above - below];
    let x = |frame: f64| left + inner[0] * frame / frames.max(1) as f64;
    let y = |flip: f64| above + inner[1] * (1.0 - flip / top);

    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" \
         font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"{0}\" height=\"{1}\" fill=\"white\"/>\n",
        SIZE[0], SIZE[1]
    );
    let text = |x: f64, y: f64, anchor: &str, words: &str| {
        format!("<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{words}</text>\n")
    };
    let line = |a: [f64; 2], b: [f64; 2], style: &str| {
        format!(
            "<line x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\" {style}/>\n",
            a[0], a[1], b[0], b[1]
        )
    };
    if let Some(run) = runs.first() {
        svg += &text(left, above - 18.0, "start", &format!("FLIP within the subject: {}", run.film_name()));
    }
    for step in 0..=(top * 20.0).round() as u32 {
        let flip = f64::from(step) / 20.0;
        svg += &line([left, y(flip)], [left + inner[0], y(flip)], "stroke=\"#dddddd\"");
        svg += &text(left - 6.0, y(flip) + 4.0, "end", &format!("{flip:.2}"));
    }
    for (phase, frame, words) in
        [(Phase::Moving, 0, "moves"), (Phase::Rest, 1, "rests"), (Phase::Cut, 0, "cut")]
    {
        let at = x(place(phase, frame) as f64);
        svg += &line([at, above], [at, above + inner[1]], "stroke=\"#999999\" stroke-dasharray=\"3 3\"");
        svg += &text(at + 2.0, above + inner[1] + 16.0, "start", words);
    }
    svg += &text(left + inner[0], above + inner[1] + 34.0, "end", &format!("{frames} frames"));
    if let Some(floor) = runs.iter().find_map(|run| run.floor) {
        svg += &line([left, y(floor)], [left + inner[0], y(floor)], "stroke=\"#999999\"");
        svg += &text(left + inner[0] + 6.0, y(floor) + 4.0, "start", "two converged pictures");
    }
    for (i, run) in runs.iter().enumerate() {
        let cost = options.costs.iter().position(|cost| *cost == run.cost).unwrap_or(0);
        let dash = if run.variant == Variant::Raw { "" } else { " stroke-dasharray=\"6 3\"" };
        let style = format!("stroke=\"{}\" stroke-width=\"2\"{dash}", COLORS[cost % COLORS.len()]);
        for phase in [Phase::Moving, Phase::Rest, Phase::Cut] {
            let at = points(run).into_iter().filter(|point| point.0 == phase);
            let at: Vec<String> =
                at.map(|(_, frame, flip)| format!("{:.1},{:.1}", x(frame as f64), y(flip))).collect();
            // A string takes whatever is written into it.
            _ = writeln!(svg, "<polyline points=\"{}\" fill=\"none\" {style}/>", at.join(" "));
        }
        let row = above + 10.0 + 18.0 * i as f64;
        let key = left + inner[0] + 12.0;
        svg += &line([key, row], [key + 26.0, row], &style);
        svg += &text(key + 32.0, row + 4.0, "start", &format!("{} {}", run.cost.name(), run.variant.name()));
    }
    svg + "</svg>\n"
}
