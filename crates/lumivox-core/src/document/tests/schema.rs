//! The schema says what the check refuses, and the page what the schema says.

use std::path::{Path, PathBuf};

use serde_json::{Map, Value, json};

use super::{super::*, scene};

fn published() -> schemars::Schema {
    let mut schema = schemars::schema_for!(SceneDocument);
    schema.insert("title".into(), "A scene of Lumivox's".into());
    schema
}

fn schema() -> Value {
    published().to_value()
}

fn docs(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs").join(name)
}

/// `LUMIVOX_UPDATE=1 cargo test -p lumivox-core schema` writes it anew.
#[test]
fn the_schema_is_published() {
    let text = serde_json::to_string_pretty(&published()).unwrap() + "\n";
    let path = docs("scene.schema.json");
    if std::env::var_os("LUMIVOX_UPDATE").is_some() {
        std::fs::write(&path, &text).unwrap();
    }
    let published = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        published == text,
        "docs/scene.schema.json is not what documents are: see the comment above this test"
    );
}

/// Whether a schema takes a value: of its words, those that this one has.
fn takes(root: &Value, schema: &Value, value: &Value) -> bool {
    let Value::Object(words) = schema else { return schema == &json!(true) };
    words.iter().all(|(word, said)| match (word.as_str(), said) {
        ("$ref", Value::String(at)) => {
            takes(root, root.pointer(at.trim_start_matches('#')).expect("a definition"), value)
        }
        ("type", Value::String(one)) => is_a(one, value),
        ("type", Value::Array(several)) => several.iter().any(|one| is_a(one.as_str().unwrap(), value)),
        ("const", said) => said.as_f64().map_or(said == value, |number| value.as_f64() == Some(number)),
        ("enum", Value::Array(all)) => all.contains(value),
        ("not", said) => !takes(root, said, value),
        ("anyOf", Value::Array(all)) => all.iter().any(|one| takes(root, one, value)),
        ("oneOf", Value::Array(all)) => all.iter().filter(|one| takes(root, one, value)).count() == 1,
        ("minimum", said) => value.as_f64().is_none_or(|number| number >= said.as_f64().unwrap()),
        ("maximum", said) => value.as_f64().is_none_or(|number| number <= said.as_f64().unwrap()),
        ("minItems", said) => value.as_array().is_none_or(|list| list.len() >= count(said)),
        ("maxItems", said) => value.as_array().is_none_or(|list| list.len() <= count(said)),
        ("minLength", said) => value.as_str().is_none_or(|text| text.chars().count() >= count(said)),
        ("items", said) => value.as_array().is_none_or(|list| {
            let first = words.get("prefixItems").and_then(Value::as_array).map_or(0, Vec::len);
            list.iter().skip(first).all(|item| takes(root, said, item))
        }),
        ("prefixItems", Value::Array(all)) => value
            .as_array()
            .is_none_or(|list| list.iter().zip(all).all(|(item, said)| takes(root, said, item))),
        ("contains", said) => {
            value.as_array().is_none_or(|list| list.iter().any(|item| takes(root, said, item)))
        }
        ("properties", Value::Object(all)) => value.as_object().is_none_or(|map| {
            map.iter().all(|(key, value)| all.get(key).is_none_or(|said| takes(root, said, value)))
        }),
        ("additionalProperties", said) => value.as_object().is_none_or(|map| {
            let known = words.get("properties").and_then(Value::as_object);
            let is_known = |key: &String| known.is_some_and(|known| known.contains_key(key));
            map.iter().all(|(key, value)| is_known(key) || takes(root, said, value))
        }),
        ("required", Value::Array(keys)) => {
            value.as_object().is_none_or(|map| keys.iter().all(|key| map.contains_key(key.as_str().unwrap())))
        }
        ("pattern" | "format" | "description" | "title" | "default" | "$schema" | "$defs", _) => true,
        (other, _) => panic!("what does {other} mean?"),
    })
}

fn is_a(kind: &str, value: &Value) -> bool {
    match kind {
        "null" => value.is_null(),
        "boolean" => value.is_boolean(),
        "string" => value.is_string(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        "number" => value.is_number(),
        "integer" => value.is_u64() || value.is_i64(),
        other => panic!("{other} is no type"),
    }
}

fn count(said: &Value) -> usize {
    said.as_u64().unwrap() as usize
}

/// Documents that say all there is, between them.
fn whole() -> Vec<Value> {
    let document = SceneDocument::of(&scene()).unwrap();
    let mut written: Value = serde_json::to_value(&document).unwrap();
    let add = |part: &mut Value, more: Value| {
        let (Value::Object(part), Value::Object(more)) = (part, more) else { panic!("two blocks") };
        part.extend(more);
    };
    let curve = json!({"opacity": [[-1000, 0.25], [50, 0.5, "in-out"]], "color": [[0, [0.1, 0.2, 0.3]]]});
    let surface = json!({
        "strength": 0.5, "gradient_per_mm": 20, "roughness": 0.3, "specular": 0.1, "metallic": 0.2
    });
    add(
        &mut written["volumes"][0],
        json!({
            "peel": 3,
            "lassos": [{
                "from_picture": [[1, 0, 0, 5], [0, 1, 0, 6], [0, 0, 1, 7]], "parallel": true, "inverted": true,
                "points": [[0, 0], [1, 0], [0, 1]]
            }],
            "look": {
                "transfer_function": curve, "gradients": [{"per_mm": 30, "transfer_function": curve}],
                "window": [40, 400], "density": 0.5, "albedo": 0.9, "anisotropy": 0.1, "bounces": 20,
                "surface": surface
            },
            "scan": {
                "files": ["head.raw"], "phase": 2, "spacing": [1, 2, 3], "slope": 2.5, "intercept": -1024,
                "taken_off": {"skin": 3}
            },
            "labels": {
                "files": ["labels.nrrd"],
                "styles": [{
                    "label": "*", "density": 0.5, "opacity": 0.5, "color": [0.1, 0.2, 0.3], "surface": surface,
                    "transfer_function": curve
                }]
            }
        }),
    );
    add(&mut written["film"], json!({"size": [320, 240], "samples": 16, "seed": 3, "noise": 0.02}));
    add(&mut written["camera"], json!({"azimuth": 20, "elevation": 10, "zoom": 1.5, "target": [1, 2, 3]}));
    add(&mut written, json!({"measurements": [{"kind": "distance", "points": [[1, 2, 3], [4, 5, 6]]}]}));
    let slab = json!({"shows": "mean", "thickness": 10});
    let oblique = json!([[1, 0, 0], [0, 1, 0]]);
    let slices = json!({"cross": [1, 2, 3], "window": [40, 400], "slab": slab, "oblique": oblique});
    add(&mut written, json!({"slices": slices}));
    written["lights"][1]["lamp"]["falloff"] = json!({"relative": {"range": 500}});
    written["lights"][2]["lamp"]["falloff"] = json!({"power": {"range": 500, "decay": 2}});
    let mut other = written.clone();
    other["volumes"][0]["scan"]["taken_off"] = json!({"depth": 3});
    add(&mut other["volumes"][0]["look"], json!({"shift": 10, "window_scale": 2}));
    other["volumes"][0]["look"].as_object_mut().unwrap().remove("window");
    other["camera"] = json!({"eye": [100, 200, 300], "fov": 30});
    other["environment"] = json!({
        "source": "gradient", "zenith": [1, 1, 1], "horizon": [1, 1, 1], "nadir": [1, 1, 1]
    });
    let mut exact = written.clone();
    exact["camera"] = json!({"world_from_camera": [[1, 0, 0, 5], [0, 1, 0, 6], [0, 0, 1, 7]]});
    vec![written, other, exact]
}

/// Every number of a document, by its pointer.
fn numbers(value: &Value, at: &str, found: &mut Vec<String>) {
    match value {
        Value::Number(_) => found.push(at.to_owned()),
        Value::Array(list) => {
            list.iter().enumerate().for_each(|(i, item)| numbers(item, &format!("{at}/{i}"), found));
        }
        Value::Object(map) => {
            map.iter().for_each(|(key, value)| numbers(value, &format!("{at}/{key}"), found));
        }
        _ => {}
    }
}

/// Every limit that a schema says of numbers.
fn limits(schema: &Value, found: &mut Vec<f64>) {
    match schema {
        Value::Object(words) => words.iter().for_each(|(word, said)| match said.as_f64() {
            Some(limit) if word == "minimum" || word == "maximum" => found.push(limit),
            _ => limits(said, found),
        }),
        Value::Array(list) => list.iter().for_each(|said| limits(said, found)),
        _ => {}
    }
}

/// What depends on more than one number: the check alone says it.
fn depends(at: &str) -> bool {
    // Low corners below high ones, inner angles below outer ones, what is turned back, how many pixels, no direction.
    [
        "/clip/",
        "/inner_half_angle",
        "/half_angle",
        "world_from",
        "/from_",
        "/film/size/",
        "/direction/",
        "/oblique/",
    ]
    .iter()
    .any(|part| at.contains(part))
}

/// At every number of a document, each limit of any field, and what lies just beyond it: schema and check refuse the same.
#[test]
fn schema_and_check_refuse_the_same_numbers() {
    let schema = schema();
    let mut tried = vec![];
    limits(&schema, &mut tried);
    tried.extend([0.0, 0.5, 1.0, 1e-300, -1e-300, 1e300, -1e300]);
    tried = tried.iter().flat_map(|x| [x.next_down(), *x, x.next_up()]).collect();
    tried.sort_by(f64::total_cmp);
    tried.dedup();
    // Those are as good as 0, and some fields are not that.
    tried.retain(|x| *x == 0.0 || x.is_normal());
    let mut refused = vec![0; 2];
    let mut known = std::collections::BTreeSet::new();
    for document in whole() {
        let text = document.to_string();
        SceneDocument::parse(&text).unwrap_or_else(|error| panic!("{error}: {text}"));
        assert!(takes(&schema, &schema, &document), "{text}");
        let mut all = vec![];
        numbers(&document, "", &mut all);
        for at in all.into_iter().filter(|at| known.insert(at.clone())) {
            let is_whole = ["/phase", "/bounces", "/layers", "/seed", "/samples", "/lumivox_scene", "/size/"]
                .iter()
                .any(|part| at.contains(part));
            let mut changed = document.clone();
            let whole = [-1.0, 0.0, 1.0, 2.0, 1000.0, 1001.0, 32_768.0, 32_769.0, 16_777_216.0, 16_777_217.0]
                .into_iter()
                .chain([f64::from(u32::MAX), f64::from(u32::MAX) + 1.0, 0.5]);
            let numbers: Vec<Value> = match is_whole {
                true => whole.map(|x| if x == 0.5 { json!(x) } else { json!(x as i64) }).collect(),
                false => tried.iter().map(|x| json!(x)).collect(),
            };
            for number in numbers {
                *changed.pointer_mut(&at).unwrap() = number.clone();
                let by_schema = !takes(&schema, &schema, &changed);
                let by_check = SceneDocument::parse(&changed.to_string()).is_err();
                let is_same = by_schema == by_check || by_check && depends(&at);
                assert!(is_same, "{at}: {number}; schema refuses: {by_schema}, check refuses: {by_check}");
                refused[usize::from(by_schema)] += 1;
            }
        }
    }
    assert!(refused.iter().all(|count| *count > 1000), "{refused:?}");
}

/// Lists that are too short or too long, names that are none, what is not said.
#[test]
fn schema_and_check_refuse_the_same_lists() {
    let schema = schema();
    let plane = json!({"kind": "plane", "from_shape": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]});
    let curve = json!({"opacity": [[0, 1]], "color": [[0, "#c0503c"]]});
    let row = json!({"per_mm": 1, "transfer_function": curve});
    let many = |one: &Value, count: usize| Value::Array(vec![one.clone(); count]);
    let scan = json!({"files": ["a"]});
    let point = json!([0, 1]);
    let lasso = |points: usize| json!({"from_picture": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]], "points": many(&point, points)});
    let look = |gradients: usize| json!({"scan": scan, "look": {"transfer_function": curve, "gradients": many(&row, gradients)}});
    for (is_right, entry) in [
        (true, json!({"scan": scan})),
        (true, json!({"scan": scan, "clip_shapes": many(&plane, 1024)})),
        (false, json!({"scan": scan, "clip_shapes": many(&plane, 1025)})),
        (true, json!({"scan": scan, "lassos": many(&lasso(4096), 1)})),
        (true, json!({"scan": scan, "lassos": many(&lasso(3), 256)})),
        (false, json!({"scan": scan, "lassos": many(&lasso(3), 257)})),
        (false, json!({"scan": scan, "lassos": [lasso(2)]})),
        (false, json!({"scan": scan, "lassos": [lasso(4097)]})),
        (true, look(32)),
        (false, look(33)),
        (false, json!({"scan": {"files": []}})),
        (false, json!({"scan": {}})),
        (false, json!({"scan": {"files": [""]}})),
        (false, json!({"scan": scan, "labels": {"files": [""]}})),
        (
            false,
            json!({"scan": scan, "look": {"transfer_function": {"opacity": [], "color": [[0, "#c0503c"]]}}}),
        ),
        (false, json!({"scan": scan, "look": {"transfer_function": {"opacity": [[0, 1]], "color": []}}})),
        (false, json!({"scan": scan, "look": {"window": [1, 2, 3]}})),
        (false, json!({"scan": {"files": ["a"], "slope": 0}})),
    ] {
        let document = json!({"lumivox_scene": 1, "volumes": [entry]});
        let taken = [takes(&schema, &schema, &document), SceneDocument::parse(&document.to_string()).is_ok()];
        assert_eq!(taken, [is_right; 2], "{document:.300}");
    }
}

/// The rows of the page's table, by the schema: of every block the keys that have a range.
fn rows(schema: &Value) -> Vec<String> {
    let blocks = [
        ("Entry", "a volume"),
        ("Lasso", "`lassos`"),
        ("Scan", "`scan`"),
        ("TakenOff", "`taken_off`"),
        ("Look", "`look`"),
        ("Reflection", "`surface`"),
        ("GradientFunction", "`gradients`"),
        ("Style", "`styles`"),
        ("Surroundings", "`environment`"),
        ("Lighting", "`lights`"),
        ("Bulb", "`lamp`"),
        ("Falloff", "`falloff`"),
        ("SpotCone", "`cone`"),
        ("View", "`camera`"),
        ("Film", "`film`"),
        ("Display", "`display`"),
        ("Measurement", "`measurements`"),
        ("Slices", "`slices`"),
        ("Slab", "`slab`"),
    ];
    let row = |(definition, name): &(&str, &str)| {
        let mut ranges = vec![];
        ranged(&schema["$defs"][*definition], "", &mut ranges);
        let mut said: Vec<String> = vec![];
        for (key, range) in ranges {
            let words = format!("`{key}` {range}");
            match said.iter_mut().find(|known| known.starts_with(&format!("`{key}`"))) {
                Some(known) if *known != words => *known += &format!(" and {range}"),
                Some(_) => {}
                None => said.push(words),
            }
        }
        format!("| {name} | {} |", said.join(", "))
    };
    blocks.iter().map(row).collect()
}

/// The ranges in a block, by their keys.
fn ranged(schema: &Value, key: &str, found: &mut Vec<(String, String)>) {
    let number = |x: f64| {
        let [short, long] = [format!("{x:e}"), x.to_string()];
        if short.len() < long.len() && !(0.001..1000.5).contains(&x.abs()) { short } else { long }
    };
    match schema {
        Value::Object(words) => {
            let limits = ["minimum", "maximum"].map(|word| words.get(word).and_then(Value::as_f64));
            if let [Some(low), Some(high)] = limits
                && high != f64::from(u32::MAX)
            {
                found.push((key.to_owned(), format!("{} to {}", number(low), number(high))));
            }
            let inner = |(word, said): (&String, &Value)| match (word.as_str(), said) {
                ("properties", Value::Object(all)) => {
                    all.iter().for_each(|(key, said)| ranged(said, key, found));
                }
                _ => ranged(said, key, found),
            };
            words.iter().for_each(inner);
        }
        Value::Array(list) => list.iter().for_each(|said| ranged(said, key, found)),
        _ => {}
    }
}

/// `LUMIVOX_UPDATE=1` shows the table that belongs there.
#[test]
fn the_page_says_the_ranges_of_the_schema() {
    let page = std::fs::read_to_string(docs("scenes.md")).unwrap();
    let rows = rows(&schema());
    if std::env::var_os("LUMIVOX_UPDATE").is_some() {
        println!("{}", rows.join("\n"));
    }
    for row in &rows {
        assert!(page.contains(row.as_str()), "docs/scenes.md lacks the line {row}");
    }
    // No block with ranges is left out.
    let schema = schema();
    let said: Map<String, Value> = schema["$defs"].as_object().unwrap().clone();
    let with_ranges = said.iter().filter(|(_, said)| {
        let mut found = vec![];
        ranged(said, "", &mut found);
        !found.is_empty()
    });
    let names: Vec<&String> = with_ranges.map(|(name, _)| name).collect();
    // Their ranges are in the words of the page.
    let others = ["Color", "Knot", "Radiance", "Rgb", "Shape", "TransferFunction"];
    assert!(names.iter().filter(|name| !others.contains(&name.as_str())).count() == rows.len(), "{names:?}");
}
