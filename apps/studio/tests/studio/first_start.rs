//! What a person meets first.

use lumivox_studio::words::Word;

use super::*;

#[test]
fn it_says_what_it_is_not_and_only_once() {
    let _alone = alone();
    let (mut studio, _) = studio_with(Settings::default());
    assert!(says(&studio, "Not a medical device. Education, research and illustration only."));
    screenshot(&mut studio, "01-first-start");
    // Nothing is opened behind the notice.
    studio.key_press_modifiers(Modifiers::COMMAND, Key::O);
    studio.step();
    assert!(studio.state().is_quiet());
    click(&mut studio, "I understand");
    assert!(studio.state().state.settings.has_agreed);
    assert!(!says(&studio, "I understand") && says(&studio, "Drop a scan here"));
    assert!(says(&studio, "No scan leaves this computer."));
    screenshot(&mut studio, "02-welcome");
    // About says it again, with the keys.
    studio.key_press(Key::F1);
    studio.step();
    studio.step();
    assert!(says(&studio, "Pictures of the Studio are not for diagnosis"));
    screenshot(&mut studio, "03-about");
    click(&mut studio, "Close");
    assert!(!says(&studio, "Pictures of the Studio are not for diagnosis"));
}

#[test]
fn it_speaks_german_and_is_bright_if_asked() {
    let _alone = alone();
    let (mut studio, _) = studio();
    let dark = screenshot(&mut studio, "welcome-dark").mean(egui::Rect::EVERYTHING);
    click(&mut studio, "Light");
    click(&mut studio, "English");
    click(&mut studio, "Deutsch");
    studio.run_steps(3);
    assert_eq!(studio.state().state.settings.language, Language::German);
    assert!(says(&studio, "Scan hier ablegen") && says(&studio, "Ordner öffnen…"));
    assert!(says(&studio, "Kein Medizinprodukt. Nur für Lehre, Forschung und Illustration."));
    let light = screenshot(&mut studio, "04-welcome-german").mean(egui::Rect::EVERYTHING);
    assert!(light > dark + 100.0, "{light} {dark}");
}

#[test]
fn every_word_is_there_in_every_language() {
    // What is the same in both, or a name.
    let same = [
        Word::Version,
        Word::ThreeD,
        Word::Axial,
        Word::Sagittal,
        Word::Pixels,
        Word::Lasso,
        Word::LookAorta,
        Word::SlabMaximum,
        Word::SlabMinimum,
    ];
    for word in Word::ALL {
        let [english, german] = [Language::English, Language::German].map(|language| word.of(language));
        assert!(!english.trim().is_empty() && !german.trim().is_empty(), "{word:?}");
        assert!(english != german || same.contains(word), "{word:?}: {english}");
        // A button that opens a dialog says so in both.
        assert_eq!(english.ends_with('…'), german.ends_with('…'), "{word:?}");
    }
    for preset in lumivox_core::Preset::ALL {
        assert!(lumivox_studio::words::look(preset).is_some(), "{}", preset.name());
    }
    for stage in lumivox_core::WorkStage::ALL {
        let word = lumivox_studio::words::stage(stage).expect("a word for each stage");
        assert_eq!(word.of(Language::English), stage.label());
    }
}
