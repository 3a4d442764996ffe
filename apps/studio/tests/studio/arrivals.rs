//! Where files lie that are given to a page, and how a scene names them.

use lumivox_core::document::{Entry, Labels, Scan, SceneDocument};
use lumivox_studio::arrivals::{Arrivals, Given};

use super::*;

fn given(files: &[(&str, u32)]) -> Vec<Given> {
    let of = |(path, size): &(&str, u32)| Given {
        path: (*path).to_owned(),
        size: f64::from(*size),
        changed: 1000.0,
    };
    files.iter().map(of).collect()
}

/// What is opened of what is given.
fn opened(arrivals: &mut Arrivals, files: &[(&str, u32)]) -> Vec<String> {
    arrivals.place(&given(files), false).tops
}

/// How a scene of these files names them.
fn saved(
    arrivals: &Arrivals,
    scan: &[&str],
    labels: &[&str],
) -> Result<(Vec<PathBuf>, Vec<PathBuf>), String> {
    let paths = |files: &[&str]| files.iter().map(PathBuf::from).collect();
    let mut entry = Entry::new(Scan { files: paths(scan), ..Scan::default() });
    entry.labels = Some(Labels { files: paths(labels), ..Labels::default() });
    let mut document = SceneDocument { volumes: vec![entry], ..SceneDocument::default() };
    arrivals.name(&mut document)?;
    let entry = document.volumes.remove(0);
    Ok((entry.scan.files, entry.labels.unwrap().files))
}

const HEAD: [(&str, u32); 2] = [("head/a.dcm", 1), ("head/b.dcm", 2)];

#[test]
fn what_is_given_again_lies_where_it_lay() {
    let mut arrivals = Arrivals::default();
    assert_eq!(opened(&mut arrivals, &HEAD), ["head"]);
    assert_eq!(opened(&mut arrivals, &HEAD), ["head"]);
    // With its scene, too; and another scene of that name takes the place of the first.
    for size in [30, 31] {
        let with = [("head.lumivox", size), HEAD[0], HEAD[1]];
        assert_eq!(opened(&mut arrivals, &with), ["head.lumivox", "head"]);
    }
    assert_eq!(opened(&mut arrivals, &[("head.lumivox", 32)]), ["head.lumivox"]);
}

#[test]
fn another_of_the_same_name_lies_apart_and_is_saved_by_its_name() {
    let mut arrivals = Arrivals::default();
    opened(&mut arrivals, &HEAD);
    // Nobody gives a folder that the page makes.
    opened(&mut arrivals, &[("<1>/a.dcm", 1)]);
    for other in [&[("head/a.dcm", 3), HEAD[1]][..], &HEAD[..1]] {
        let [top] = &opened(&mut arrivals, other)[..] else { panic!("a folder is one") };
        assert!(top.ends_with(">/head") && !top.starts_with("<1>"), "{top}");
        assert_eq!(saved(&arrivals, &[top], &[]).unwrap().0, [Path::new("head")]);
        // Its scene, which comes alone, is of it; so it is again with all.
        let before = top.trim_end_matches("head");
        assert_eq!(opened(&mut arrivals, &[("head.lumivox", 30)]), [format!("{before}head.lumivox")]);
        assert_eq!(opened(&mut arrivals, other), std::slice::from_ref(top));
    }
    assert_eq!(opened(&mut arrivals, &HEAD), ["head"]);
    assert_eq!(saved(&arrivals, &["<1>"], &[]).unwrap().0, [Path::new("<1>")]);
}

#[test]
fn a_header_and_its_samples_are_opened_together_and_saved_as_the_header() {
    let mut arrivals = Arrivals::default();
    opened(&mut arrivals, &HEAD);
    for (header, samples) in [("a.nhdr", "a.raw"), ("a.mhd", "b.raw"), ("a.hdr", "a.img")] {
        let pair = [(samples, 100), (header, 10)];
        let [folder] = &opened(&mut arrivals, &pair)[..] else { panic!("a folder is one") };
        assert!(folder.starts_with('<'), "{folder}");
        let name = Path::new(header);
        assert_eq!(
            saved(&arrivals, &[folder], &["head"]).unwrap(),
            (vec![name.to_owned()], vec!["head".into()])
        );
        assert_eq!(saved(&arrivals, &[&format!("{folder}/./{header}")], &[]).unwrap().0, [name]);
        // The scene lies beside the header that it names.
        let with = [("a.lumivox", 5), pair[0], pair[1]];
        assert_eq!(opened(&mut arrivals, &with), [format!("{folder}/a.lumivox"), folder.clone()]);
        assert_eq!(opened(&mut arrivals, &pair), std::slice::from_ref(folder));
        // With another file it is another folder.
        assert_ne!(opened(&mut arrivals, &[pair[0], pair[1], ("c.txt", 1)]), std::slice::from_ref(folder));
    }
    let [folder] = &opened(&mut arrivals, &[("1.dcm", 1), ("2.dcm", 2)])[..] else {
        panic!("a folder is one")
    };
    assert_eq!(saved(&arrivals, &[folder], &[]).unwrap().0, [Path::new("1.dcm"), Path::new("2.dcm")]);
}

#[test]
fn structures_are_asked_for_one_by_one() {
    let mut arrivals = Arrivals::default();
    opened(&mut arrivals, &[("a.nii", 1)]);
    let placed = arrivals.place(&given(&[("a.nii", 2), ("b.nii", 3)]), true);
    assert_eq!(placed.tops, [format!("{}a.nii", placed.before), format!("{}b.nii", placed.before)]);
    assert!(!placed.before.is_empty());
    // A scene cannot say which is which.
    let [a, b] = &placed.tops[..] else { panic!("two are two") };
    let why = saved(&arrivals, &["a.nii"], &[a]).unwrap_err();
    assert!(why.starts_with("a.nii: ") && why.contains("rename"), "{why}");
    assert_eq!(saved(&arrivals, &["a.nii"], &[b]).unwrap().1, [Path::new("b.nii")]);
}
