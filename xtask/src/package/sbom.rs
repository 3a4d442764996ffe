//! What a package is made of, for programs that look for vulnerable parts: CycloneDX 1.6 in JSON.

use serde_json::{Value, json};

use super::archive;
use super::works::Work;

/// The bill of what is linked into a package; `roots` are the packages of ours that it was built of.
pub fn write(name: &str, version: &str, roots: &[&str], works: &[Work], date: u64) -> Result<String, String> {
    let reference = format!("pkg:generic/{name}@{version}");
    let component = |work: &Work| {
        let mut component = json!({
            "type": "library",
            "bom-ref": work.purl(),
            "name": work.name,
            "version": work.version,
            "licenses": [{ "expression": work.license }],
            "purl": work.purl(),
        });
        if !work.authors.is_empty() {
            component["authors"] = work.authors.iter().map(|name| json!({ "name": name })).collect();
        }
        if let Some(checksum) = &work.checksum {
            component["hashes"] = json!([{ "alg": "SHA-256", "content": checksum }]);
        }
        if !work.home.is_empty() {
            component["externalReferences"] = json!([{ "type": "vcs", "url": work.home }]);
        }
        component
    };
    let purl_of = |key: &(String, String)| {
        let found = works.iter().find(|work| work.key() == *key).map(Work::purl);
        found.ok_or_else(|| format!("{key:?} is linked, and not listed"))
    };
    // What builds nothing of ours, such as the standard library, is the package's own affair.
    let is_root = |work: &&Work| roots.contains(&work.name.as_str()) || work.kind == "generic";
    let mut dependencies = vec![json!({
        "ref": reference,
        "dependsOn": works.iter().filter(is_root).map(Work::purl).collect::<Vec<_>>(),
    })];
    for work in works {
        let used = work.uses.iter().map(purl_of).collect::<Result<Vec<_>, _>>()?;
        dependencies.push(json!({ "ref": work.purl(), "dependsOn": used }));
    }
    let mut bill = json!({
        "bomFormat": "CycloneDX",
        "specVersion": "1.6",
        "version": 1,
        "metadata": {
            "timestamp": archive::iso(date),
            "tools": { "components": [{ "type": "application", "name": "cargo xtask package", "version": version }] },
            "component": {
                "type": "application",
                "bom-ref": reference,
                "name": name,
                "version": version,
                "licenses": [{ "expression": "MIT OR Apache-2.0" }],
                "purl": reference,
            },
        },
        "components": works.iter().map(component).collect::<Vec<Value>>(),
        "dependencies": dependencies,
    });
    // A number of its own for each content, and the same for the same.
    let hash = archive::sha256(bill.to_string().as_bytes());
    let parts = [&hash[..8], &hash[8..12], &format!("5{}", &hash[13..16]), &format!("8{}", &hash[17..20])];
    bill["serialNumber"] = format!("urn:uuid:{}-{}", parts.join("-"), &hash[20..32]).into();
    serde_json::to_string_pretty(&bill).map(|text| text + "\n").map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn work(name: &str, uses: &[&str]) -> Work {
        Work {
            name: name.to_owned(),
            version: "1.0.0+c.2".to_owned(),
            license: "MIT".to_owned(),
            authors: vec!["A. Nyone".to_owned()],
            home: "https://example.org".to_owned(),
            checksum: Some("00".repeat(32)),
            texts: vec![],
            uses: uses.iter().map(|name| ((*name).to_owned(), "1.0.0+c.2".to_owned())).collect(),
            is_own: false,
            kind: "cargo",
        }
    }

    #[test]
    fn every_part_is_named_by_its_purl_and_hangs_on_the_package() {
        let works = [work("a", &["b"]), work("b", &[])];
        let text = write("tool", "0.1.0", &["a"], &works, 0).unwrap();
        assert_eq!(text, write("tool", "0.1.0", &["a"], &works, 0).unwrap());
        let bill: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(bill["specVersion"], "1.6");
        assert_eq!(bill["components"][1]["purl"], "pkg:cargo/b@1.0.0%2Bc.2");
        assert_eq!(
            bill["dependencies"][0],
            json!({ "ref": "pkg:generic/tool@0.1.0", "dependsOn": ["pkg:cargo/a@1.0.0%2Bc.2"] })
        );
        assert_eq!(bill["dependencies"][1]["dependsOn"], json!(["pkg:cargo/b@1.0.0%2Bc.2"]));
        let serial = bill["serialNumber"].as_str().unwrap();
        let lengths: Vec<usize> = serial.trim_start_matches("urn:uuid:").split('-').map(str::len).collect();
        assert_eq!(lengths, [8, 4, 4, 4, 12]);
        let other = write("tool", "0.2.0", &["a"], &works, 0).unwrap();
        assert!(!other.contains(serial));
        assert!(write("tool", "0.1.0", &["a"], &[work("a", &["gone"])], 0).is_err());
    }
}
