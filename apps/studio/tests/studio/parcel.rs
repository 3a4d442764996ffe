//! What crosses between a page and its Worker arrives as it was sent.

use lumivox_core::document::{Entry, SceneDocument};
use lumivox_core::{EnvironmentMap, EnvironmentSource, Preset, Subject};
use lumivox_studio::jobs::elsewhere;
use lumivox_studio::opening::show;
use lumivox_studio::parcel::{Bytes, Errand, Packer, SceneWords, Unpacker};

use super::*;

struct Arrived(Vec<Vec<u8>>);

impl Bytes for Arrived {
    fn length(&self, number: usize) -> usize {
        self.0[number].len()
    }

    fn copy(&self, number: usize, into: &mut [u8]) {
        into.copy_from_slice(&self.0[number]);
    }
}

/// A head with labels, peeled, in the light of a map.
fn peeled_head() -> (SceneDocument, lumivox_core::Scene) {
    let options = AnatomyOptions { size: 32, ..Default::default() };
    let volume = anatomy(options, Progress::SILENT, &CancelToken::new()).unwrap();
    let mut subject = Subject::default();
    subject.contrast = Some(true);
    let volume = Arc::new(volume.with_subject(subject));
    let mut entry = Entry::new(Default::default());
    (entry.labels, entry.peel) = (Some(Default::default()), Some(1.0 / 3.0));
    entry.look.preset = Some(Preset::CtBone);
    let document = SceneDocument { volumes: vec![entry], ..SceneDocument::default() };
    let (_job, desk) = elsewhere::<()>(Arc::new(|| {}), || {});
    let (mut scene, _) = show(&document, vec![volume], &desk).unwrap();
    let map = EnvironmentMap::from_fn(8, 4, |direction| [direction.x.abs(), 0.1, 1.0 / 3.0]);
    scene.environment.source = EnvironmentSource::Map(Arc::new(map));
    (document, scene)
}

#[test]
fn a_scene_arrives_as_it_was_sent() {
    let (document, scene) = peeled_head();
    let sent = &scene.volumes[0];
    let mut packer = Packer::default();
    let words = packer.scene(&document, &scene).unwrap();
    assert_eq!(packer.volume(&sent.volume), packer.volume(&sent.volume), "a volume is sent once");
    let letter = packer.letter(words);
    let bytes = Arrived(packer.bytes().map(<[u8]>::to_vec).collect());
    let (words, mut with) = Unpacker::open::<SceneWords>(&letter, &bytes).unwrap();
    let (again, arrived) = with.scene(words).unwrap();
    assert_eq!(again, document);
    let arrived = &arrived.volumes[0];
    for (one, other) in [
        (&arrived.volume, &sent.volume),
        (&arrived.peel.as_ref().unwrap().depth, &sent.peel.as_ref().unwrap().depth),
    ] {
        assert_eq!((one.dims(), one.voxels()), (other.dims(), other.voxels()));
        assert_eq!(one.patient_from_voxel(), other.patient_from_voxel());
        assert_eq!(
            (one.slope(), one.intercept(), one.unit()),
            (other.slope(), other.intercept(), other.unit())
        );
        assert_eq!((one.modality(), one.subject()), (other.modality(), other.subject()));
        assert_eq!(one.source(), other.source());
    }
    let [one, other] = [arrived, sent].map(|instance| &instance.labels.as_ref().unwrap().labels);
    assert!(one == other && one.labels().len() > 2 && one.source() == other.source());
    assert_eq!(arrived.peel.as_ref().unwrap().mm, 1.0 / 3.0);
    assert_eq!(arrived.medium, sent.medium);
    assert_eq!(arrived.world_from_patient, sent.world_from_patient);
}

#[test]
fn what_two_volumes_share_is_sent_once_and_shared_again() {
    let (mut document, mut scene) = peeled_head();
    document.volumes.push(document.volumes[0].clone());
    scene.volumes.push(scene.volumes[0].clone());
    let mut packer = Packer::default();
    let words = packer.scene(&document, &scene).unwrap();
    // The scan, its labels, how deep it lies, and the map.
    assert_eq!(packer.bytes().count(), 4);
    let letter = packer.letter(words);
    let bytes = Arrived(packer.bytes().map(<[u8]>::to_vec).collect());
    let (words, mut with) = Unpacker::open::<SceneWords>(&letter, &bytes).unwrap();
    let arrived = with.scene(words).unwrap().1.volumes;
    let [one, other] = [0, 1].map(|place| &arrived[place]);
    assert!(Arc::ptr_eq(&one.volume, &other.volume));
    let [one, other] = [one, other].map(|instance| &instance.labels.as_ref().unwrap().labels);
    assert!(Arc::ptr_eq(one, other));
}

#[test]
fn what_is_no_letter_is_said_and_breaks_nothing() {
    let bytes = Arrived(vec![]);
    assert!(Unpacker::open::<Errand>("{}", &bytes).is_err());
    let letter = Packer::default().letter(Errand::Open(vec!["a".into()]));
    let (errand, mut with) = Unpacker::open::<Errand>(&letter, &bytes).unwrap();
    assert!(matches!(errand, Errand::Open(files) if files == [PathBuf::from("a")]));
    assert!(with.volume(0).unwrap_err().contains("is not there"));
}

#[test]
fn what_was_sent_before_is_not_sent_again() {
    let (document, scene) = peeled_head();
    let shown = scene.volumes[0].volume.clone();
    let mut packer = Packer::knowing(vec![shown.clone()]);
    let words = packer.scene(&document, &scene).unwrap();
    let letter = packer.letter(words);
    let bytes = Arrived(packer.bytes().map(<[u8]>::to_vec).collect());
    // Labels, depths and the map.
    assert_eq!(bytes.0.len(), 3);
    let (words, mut with) = Unpacker::open::<SceneWords>(&letter, &bytes).unwrap();
    assert!(with.know(&[]).unwrap_err().contains("is not there"));
    with.know(std::slice::from_ref(&shown)).unwrap();
    let (_, arrived) = with.scene(words).unwrap();
    let [arrived, sent] = [&arrived.volumes[0], &scene.volumes[0]];
    assert!(Arc::ptr_eq(&arrived.volume, &shown));
    assert!(arrived.labels.as_ref().unwrap().labels == sent.labels.as_ref().unwrap().labels);
    let [depth, other] = [arrived, sent].map(|it| it.peel.as_ref().unwrap().depth.voxels().clone());
    assert!(depth == other);
}
