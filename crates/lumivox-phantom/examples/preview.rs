//! Throw-away preview.
use glam::{DVec3, Vec3};
use lumivox_core::{CancelToken, Preset, Progress, Volume, Voxels};
use lumivox_phantom::{AnatomyOptions, anatomy};
use rayon::prelude::*;
use std::io::BufWriter;

fn png(path: &str, w: usize, h: usize, data: &[u8], color: bool) {
    let f = BufWriter::new(std::fs::File::create(path).unwrap());
    let mut e = png::Encoder::new(f, w as u32, h as u32);
    e.set_color(if color { png::ColorType::Rgb } else { png::ColorType::Grayscale });
    e.write_header().unwrap().write_image_data(data).unwrap();
}
struct V {
    n: usize,
    s: Vec<u16>,
    inv: f32,
    first: Vec3,
}
impl V {
    #[inline]
    fn at(&self, p: Vec3) -> f32 {
        let q = (p - self.first) * self.inv;
        let n = self.n;
        let m = (n - 1) as f32;
        if q.x < 0.0 || q.y < 0.0 || q.z < 0.0 || q.x >= m || q.y >= m || q.z >= m {
            return -1000.0;
        }
        let (x, y, z) = (q.x as usize, q.y as usize, q.z as usize);
        let (fx, fy, fz) = (q.x - x as f32, q.y - y as f32, q.z - z as f32);
        let i = (z * n + y) * n + x;
        let g = |o: usize| self.s[i + o] as f32;
        let l = |o: usize| g(o) * (1.0 - fx) + g(o + 1) * fx;
        let a = l(0) * (1.0 - fy) + l(n) * fy;
        let b = l(n * n) * (1.0 - fy) + l(n * n + n) * fy;
        a * (1.0 - fz) + b * fz - 1024.0
    }
    fn grad(&self, p: Vec3, h: f32) -> Vec3 {
        let d = |e: Vec3| self.at(p + e * h) - self.at(p - e * h);
        Vec3::new(d(Vec3::X), d(Vec3::Y), d(Vec3::Z))
    }
}
/// First hit of an opacity-accumulating ray: colour by transfer function, shading by gradient, AO and a shadow.
fn view(
    v: &V,
    vol: &Volume,
    preset: Preset,
    az: f32,
    el: f32,
    w: usize,
    h: usize,
    target: Vec3,
    width_mm: f32,
    clip: Option<(Vec3, f32)>,
    path: &str,
) {
    let medium = preset.medium(vol);
    let lut: Vec<(f32, Vec3)> = (0..4096)
        .map(|i| {
            let hu = i as f64 - 1024.0;
            let c = medium.transfer_function.color(hu);
            (
                (medium.transfer_function.opacity(hu) * medium.density_scale) as f32,
                Vec3::new(c[0] as f32, c[1] as f32, c[2] as f32),
            )
        })
        .collect();
    let cut = |p: Vec3| clip.is_some_and(|(n, o)| n.dot(p) > o);
    let look = |p: Vec3| if cut(p) { lut[0] } else { lut[((v.at(p) + 1024.0) as usize).min(4095)] };
    let out = Vec3::new(az.sin() * el.cos(), -az.cos() * el.cos(), el.sin());
    let right = Vec3::new(az.cos(), az.sin(), 0.0);
    let up = right.cross(-out).normalize();
    let light = (out * 0.6 - right * 0.7 + up * 0.75).normalize();
    let step = 0.5 / v.inv;
    let dirs: Vec<Vec3> = (0..24)
        .map(|i| {
            let t = (i as f32 + 0.5) / 24.0;
            let a = i as f32 * 2.39996;
            let z = 1.0 - 2.0 * t;
            let r = (1.0 - z * z).sqrt();
            Vec3::new(r * a.cos(), r * a.sin(), z)
        })
        .collect();
    let data: Vec<u8> = (0..h)
        .into_par_iter()
        .flat_map_iter(|y| {
            let mut row = Vec::with_capacity(w * 3);
            for x in 0..w {
                let px = width_mm / w as f32;
                let o = target + right * ((x as f32 + 0.5 - w as f32 / 2.0) * px)
                    - up * ((y as f32 + 0.5 - h as f32 / 2.0) * px)
                    + out * 260.0;
                let mut trans = 1.0f32;
                let mut col = Vec3::ZERO;
                let mut t = 0.0;
                while t < 520.0 && trans > 0.03 {
                    let p = o - out * t;
                    let (s, c) = look(p);
                    if s > 0.002 {
                        let a = 1.0 - (-s * step).exp();
                        // Shade only where it matters.
                        let wgt = trans * a;
                        if wgt > 0.02 {
                            let g = v.grad(p, 1.0 / v.inv);
                            let n = -g.normalize_or_zero();
                            let shadow = |d: Vec3, reach: f32, st: f32| {
                                let mut od = 0.0;
                                let mut t = st * 1.2;
                                while t < reach && od < 4.0 {
                                    od += look(p + n * st * 0.7 + d * t).0 * st;
                                    t += st;
                                }
                                (-od).exp()
                            };
                            let sh = shadow(light, 60.0, 2.0);
                            let mut ao = 0.0;
                            let mut wsum = 0.0;
                            for d in &dirs {
                                let c = n.dot(*d);
                                if c > 0.1 {
                                    wsum += c;
                                    ao += c * shadow(*d, 18.0, 2.5);
                                }
                            }
                            let ao = if wsum > 0.0 { ao / wsum } else { 1.0 };
                            let dif = n.dot(light).max(0.0) * sh;
                            let hv = (light + out).normalize();
                            let sp = n.dot(hv).max(0.0).powf(24.0) * sh * 0.18;
                            col +=
                                wgt * (c * (dif * 0.95 + ao * (0.38 + 0.12 * n.dot(up))) + Vec3::splat(sp));
                        } else {
                            col += wgt * c * 0.4;
                        }
                        trans *= 1.0 - a;
                    }
                    t += step;
                }
                let bg = 0.035;
                let c = col + Vec3::splat(trans * bg);
                for k in c.to_array() {
                    row.push(((k.clamp(0.0, 1.0)).powf(1.0 / 2.2) * 255.0) as u8);
                }
            }
            row
        })
        .collect();
    MOSAIC.lock().unwrap().push((w, data.clone()));
    let _ = path;
}
static MOSAIC: std::sync::Mutex<Vec<(usize, Vec<u8>)>> = std::sync::Mutex::new(Vec::new());
fn slice(v: &V, axis: usize, at: f32, path: &str) {
    let n = 512;
    let mut data = vec![0u8; n * n];
    for y in 0..n {
        for x in 0..n {
            let (a, b) = (x as f32 / n as f32 * 319.0, y as f32 / n as f32 * 319.0);
            let lo = v.first;
            let p = match axis {
                2 => Vec3::new(lo.x + a, lo.y + b, at),
                1 => Vec3::new(lo.x + a, at, lo.z + 319.0 - b),
                _ => Vec3::new(at, lo.y + a, lo.z + 319.0 - b),
            };
            let hu = v.at(p);
            data[y * n + x] = (((hu + std::env::var("LO").map_or(160.0, |v| v.parse().unwrap()))
                / std::env::var("WW").map_or(460.0, |v| v.parse::<f32>().unwrap()))
            .clamp(0.0, 1.0)
                * 255.0) as u8;
        }
    }
    MOSAIC.lock().unwrap().push((n, data.iter().flat_map(|d| [*d; 3]).collect()));
    let _ = path;
}
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let size: usize = args[1].parse().unwrap();
    let t = std::time::Instant::now();
    let vol = anatomy(AnatomyOptions { size, ..Default::default() }, Progress::SILENT, &CancelToken::new())
        .unwrap();
    eprintln!("anatomy {size}: {:?}", t.elapsed());
    if args.len() < 3 {
        return;
    }
    let Voxels::U16(s) = vol.voxels() else { panic!() };
    let first = vol.patient_from_voxel().transform_point3(DVec3::ZERO);
    let v = V { n: size, s: s.clone(), inv: (1.0 / vol.spacing_mm().x) as f32, first: first.as_vec3() };
    for spec in &args[2..] {
        let path = format!("/work/main/.scratch/{spec}.png");
        let (kind, rest) = spec.split_once('-').unwrap();
        if let Some(axis) = ["sx", "sy", "sz"].iter().position(|a| *a == kind) {
            slice(&v, axis, rest.replace('m', "-").parse().unwrap(), &path);
            continue;
        }
        let preset = match &kind[..1] {
            "b" => Preset::CtBone,
            "s" => Preset::CtSkin,
            "m" => Preset::CtMuscle,
            "a" => Preset::CtAngiography,
            "S" => Preset::CtSkin,
            _ => panic!(),
        };
        let az: f32 = rest.replace('m', "-").parse().unwrap();
        let zoom = kind.len() > 1 && &kind[1..2] == "z";
        let clip = (kind.len() > 1 && &kind[1..2] == "c").then_some((Vec3::Z, 62.0));
        let (target, width) =
            if zoom { (Vec3::new(0.0, -40.0, -20.0), 200.0) } else { (Vec3::new(0.0, -10.0, -24.0), 340.0) };
        let el = if clip.is_some() { 0.6 } else { 0.0 };
        let px = std::env::var("PX").ok().and_then(|p| p.parse().ok()).unwrap_or(600);
        view(&v, &vol, preset, az.to_radians(), el, px, px, target, width, clip, &path);
        eprintln!("{spec} {:?}", t.elapsed());
    }
    let m = MOSAIC.lock().unwrap();
    let cols = m.len().min(3);
    let rows = m.len().div_ceil(3);
    let w = m[0].0;
    let mut out = vec![0u8; cols * rows * w * w * 3];
    for (i, (n, d)) in m.iter().enumerate() {
        for y in 0..(*n).min(w) {
            for x in 0..(*n).min(w) {
                for c in 0..3 {
                    out[(((i / 3) * w + y) * cols * w + (i % 3) * w + x) * 3 + c] = d[(y * n + x) * 3 + c];
                }
            }
        }
    }
    png(
        &format!("/work/main/.scratch/{}.png", std::env::var("OUT").unwrap_or("out".into())),
        cols * w,
        rows * w,
        &out,
        true,
    );
}
