//! Every word of the interface, in every language, in one table; what goes wrong with an archive is in `archive/told.rs`. What the
//! importer and the scene say of a scan are sentences of theirs, in English.

use lumivox_core::{Preset, WorkStage};
use serde::{Deserialize, Serialize};

/// A language of the interface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Language {
    /// English.
    #[default]
    English,
    /// Deutsch.
    German,
}

impl Language {
    /// Every language, by its own name.
    pub const ALL: [(Self, &'static str); 2] = [(Self::English, "English"), (Self::German, "Deutsch")];
}

macro_rules! words {
    ($($name:ident: $english:literal / $german:literal;)*) => {
        /// A word or sentence of the interface.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[expect(missing_docs, reason = "each is what it says")]
        pub enum Word { $($name),* }

        impl Word {
            /// All of them.
            pub const ALL: &'static [Self] = &[$(Self::$name),*];

            /// As it is said.
            pub fn of(self, language: Language) -> &'static str {
                match (self, language) {
                    $(
                        (Self::$name, Language::English) => $english,
                        (Self::$name, Language::German) => $german,
                    )*
                }
            }
        }
    };
}

words! {
    OpenFiles: "Open files…" / "Dateien öffnen…";
    OpenFolder: "Open folder…" / "Ordner öffnen…";
    Archive: "Archive…" / "Archiv…";
    ArchiveTitle: "Open from an archive" / "Aus einem Archiv öffnen";
    ArchiveAddress: "Address (DICOMweb)" / "Adresse (DICOMweb)";
    ArchiveName: "User name" / "Benutzername";
    ArchivePassword: "Password, or a token alone" / "Passwort, oder nur ein Token";
    ArchivePatient: "Patient's name" / "Name des Patienten";
    ArchivePatientId: "Patient ID" / "Patienten-ID";
    ArchiveDays: "Day, or from - to" / "Tag, oder von - bis";
    ArchiveModality: "Modality" / "Modalität";
    ArchiveDay: "Day" / "Tag";
    ArchiveDescription: "Description" / "Beschreibung";
    ArchiveImages: "Images" / "Bilder";
    ArchiveSearch: "Search" / "Suchen";
    ArchiveStop: "Stop asking" / "Nicht weiter fragen";
    ArchiveStudies: "Studies" / "Studien";
    ArchiveNone: "No study matches." / "Keine Studie passt.";
    ArchiveMore: "The first studies; there are more" / "Die ersten Studien; es gibt weitere";
    ArchiveOpen: "Open series" / "Serie öffnen";
    ArchiveReadable: "This address is not encrypted: others in the network can read names and the password." / "Diese Adresse ist unverschlüsselt: andere im Netz können Namen und Passwort mitlesen.";
    ArchivePrivacy: "The search goes to this archive and to nobody else." / "Die Suche geht an dieses Archiv und an niemanden sonst.";
    ArchiveKept: "Images that come are kept in" / "Empfangene Bilder liegen in";
    ArchiveForget: "Delete them…" / "Löschen…";
    ArchiveForgetWhy: "Scenes that were saved of them lose their scans." / "Gespeicherte Szenen verlieren dann ihre Scans.";
    ArchiveNoFolder: "This system has no folder where images could be kept." / "Dieses System hat keinen Ordner für empfangene Bilder.";
    ArchiveForgetAll: "Delete all images that came" / "Alle empfangenen Bilder löschen";
    SaveScene: "Save scene…" / "Szene speichern…";
    Export: "Export picture…" / "Bild exportieren…";
    Share: "Share…" / "Teilen…";
    ShareTitle: "Share as a page" / "Als Seite teilen";
    ShareWhat: "One file that opens in a browser: the 3D view, which can be turned, of this scan in fewer voxels. It needs no network and sends nothing." / "Eine Datei, die sich im Browser öffnet: die 3D-Ansicht, drehbar, von diesem Scan in weniger Voxeln. Sie braucht kein Netz und sendet nichts.";
    ShareFace: "A face identifies a person; so may teeth, bones and implants. Whoever has the file has the scan, with the names of its structures and all that planes, boxes and hidden structures hide. What a lasso cut away or was taken off from the skin is not in it." / "Ein Gesicht verrät, wer jemand ist; auch Zähne, Knochen und Implantate können es. Wer die Datei hat, hat den Scan, mit den Namen seiner Strukturen und allem, was Ebenen, Quader und ausgeblendete Strukturen verbergen. Was ein Lasso weggeschnitten hat oder von der Haut abgenommen ist, ist nicht darin.";
    ShareMay: "I may give this scan to others" / "Ich darf diesen Scan weitergeben";
    ShareSide: "Voxels a side, at most" / "Voxel je Seite, höchstens";
    ShareSave: "Save page…" / "Seite speichern…";
    Sharing: "Writing the page" / "Seite entsteht";
    ShareNoViewer: "The program for pages is not here: the Studio's packages have it, and in a clone script/js makes it." / "Das Programm für Seiten fehlt hier: Die Pakete des Studios haben es, und in einem Klon baut es script/js.";
    PageHint: "Drag to turn, right button to move, wheel to come closer" / "Ziehen dreht, rechte Taste verschiebt, Rad holt näher";
    PageReset: "Reset view" / "Ansicht zurücksetzen";
    PageAsShared: "As shared" / "Wie geteilt";
    TakenBack: "Taken back" / "Zurückgenommen";
    Undo: "Undo" / "Rückgängig";
    Redo: "Redo" / "Wiederholen";
    About: "About" / "Über";
    Close: "Close" / "Schließen";
    Cancel: "Cancel" / "Abbrechen";
    Understood: "I understand" / "Verstanden";
    LightTheme: "Light" / "Hell";
    DarkTheme: "Dark" / "Dunkel";
    DropHere: "Drop a scan here" / "Scan hier ablegen";
    DropFormats: "A DICOM folder or zip, NIfTI, NRRD, MetaImage, MGH, NumPy, TIFF, PNG, OME-Zarr, or a scene file" / "Ein DICOM-Ordner oder Zip, NIfTI, NRRD, MetaImage, MGH, NumPy, TIFF, PNG, OME-Zarr oder eine Szenendatei";
    StaysHere: "No scan leaves this computer." / "Kein Scan verlässt diesen Rechner.";
    NoDevice: "Not a medical device. Education, research and illustration only." / "Kein Medizinprodukt. Nur für Lehre, Forschung und Illustration.";
    NoDeviceLong: "Pictures of the Studio are not for diagnosis, nor for planning a treatment." / "Bilder des Studios sind weder für Befunde noch für die Planung einer Behandlung.";
    AboutText: "Scans, seen by simulating how light travels through the body." / "Scans, gesehen durch die Simulation des Lichts im Körper.";
    Version: "Version" / "Version";
    Reading: "Reading" / "Lese";
    Preparing: "Preparing the first picture" / "Erstes Bild entsteht";
    Showing: "Preparing the look" / "Darstellung entsteht";
    Rendering: "Rendering the picture" / "Bild wird berechnet";
    StageScanning: "reading headers" / "lese Kopfdaten";
    StageDecoding: "decoding slices" / "dekodiere Schichten";
    StageGenerating: "growing the phantom" / "Phantom entsteht";
    StageSegmenting: "finding the patient" / "suche den Patienten";
    StageCutting: "cutting" / "schneide";
    StageWriting: "writing slices" / "schreibe Schichten";
    StageReceiving: "receiving images" / "empfange Bilder";
    Series: "Series" / "Serien";
    SkippedFiles: "Files left out" / "Ausgelassene Dateien";
    ShowAll: "Show all" / "Alle zeigen";
    ShowLess: "Show less" / "Weniger zeigen";
    Notes: "Notes" / "Hinweise";
    Looks: "Look" / "Darstellung";
    Curve: "Opacity and colour" / "Deckkraft und Farbe";
    CurveOpacity: "Opacity point" / "Deckkraftpunkt";
    CurveColor: "Colour point" / "Farbpunkt";
    CurveHint: "Drag; right click removes" / "Ziehen; Rechtsklick entfernt";
    CurveIdle: "Drag points; double click adds one" / "Punkte ziehen; Doppelklick fügt einen hinzu";
    CurveRemove: "Remove point" / "Punkt entfernen";
    CurveAddPoint: "Add point" / "Punkt hinzufügen";
    CurveAddColor: "Add colour" / "Farbe hinzufügen";
    Light: "Lighting" / "Beleuchtung";
    Environment: "Light around" / "Umgebungslicht";
    EnvironmentStudio: "Studio light" / "Studiolicht";
    EnvironmentEven: "Even" / "Gleichmäßig";
    EnvironmentSky: "Sky" / "Himmel";
    EnvironmentFile: "Panorama…" / "Panoramabild…";
    EnvironmentFileHint: "Light of a place: a panorama as .hdr or .exr" / "Licht eines Ortes: ein Panorama als .hdr oder .exr";
    EnvironmentStrength: "Light around" / "Umgebungslicht";
    EnvironmentRotation: "Turn light" / "Licht drehen";
    KeyLight: "Key light" / "Führungslicht";
    KeyLightBall: "Direction of the key light" / "Richtung des Führungslichts";
    KeyLightHint: "Drag to where the light comes from; beyond the edge, from behind" / "Dorthin ziehen, woher das Licht kommt; über den Rand hinaus von hinten";
    KeyLightStrength: "Strength of the key light" / "Stärke des Führungslichts";
    Exposure: "Exposure" / "Belichtung";
    Shift: "Shift" / "Verschiebung";
    Width: "Width" / "Breite";
    Stops: "EV" / "LW";
    Cut: "Cut" / "Schnitt";
    CutRight: "From the right" / "Von rechts";
    CutLeft: "From the left" / "Von links";
    CutFront: "From the front" / "Von vorn";
    CutBack: "From the back" / "Von hinten";
    CutFeet: "From the feet" / "Von den Füßen";
    CutHead: "From the head" / "Vom Kopf";
    CutHint: "Drag the orange handles in the 3D view, too." / "Auch an den orangen Griffen in der 3D-Ansicht ziehen.";
    CutHandle: "Cut handle" / "Schnittgriff";
    CutFlip: "Flip" / "Umkehren";
    CutRemove: "Remove" / "Entfernen";
    Plane: "Plane" / "Ebene";
    PlaneAdd: "Cut by a plane that faces me" / "Ebene zu mir hin schneiden";
    Box: "Box" / "Quader";
    BoxAdd: "Keep a box" / "Quader behalten";
    Sphere: "Ball" / "Kugel";
    SphereAdd: "Cut out a ball" / "Kugel ausschneiden";
    Cube: "Orientation cube" / "Orientierungswürfel";
    CubeHint: "A click on a side turns to it" / "Ein Klick auf eine Seite dreht dorthin";
    Lasso: "Lasso" / "Lasso";
    LassoDraw: "Cut by a lasso" / "Mit dem Lasso schneiden";
    LassoHint: "Drag around what is to go: it is cut away as deep as the scan is" / "Umfahren, was weg soll: Es wird so tief herausgeschnitten, wie der Scan reicht";
    CutNothing: "Uncut" / "Ungeschnitten";
    Peel: "Skin off" / "Haut ab";
    PeelHint: "How deep below the skin the picture begins" / "Wie tief unter der Haut das Bild beginnt";
    Everything: "All that was scanned" / "Alles Gescannte";
    EverythingHint: "Table, clothes and tubes, too" / "Auch Tisch, Kleidung und Schläuche";
    ThreeD: "3D" / "3D";
    Axial: "Axial" / "Axial";
    Coronal: "Coronal" / "Koronal";
    Sagittal: "Sagittal" / "Sagittal";
    Oblique: "Oblique" / "Schräg";
    ObliqueHint: "A slice that is turned: drag the round handles of its line" / "Eine gedrehte Schicht: an den runden Griffen ihrer Linie ziehen";
    ObliqueTurn: "Turn the oblique slice" / "Schräge Schicht drehen";
    Navigate: "Navigate" / "Navigieren";
    NavigateHint: "Turn, scroll, window, place the cross" / "Drehen, blättern, fenstern, Kreuz setzen";
    Distance: "Distance" / "Strecke";
    DistanceHint: "Drag or click from point to point; in 3D, click" / "Von Punkt zu Punkt ziehen oder klicken; in 3D klicken";
    Angle: "Angle" / "Winkel";
    AngleHint: "Click three points; the second is the vertex" / "Drei Punkte klicken; der zweite ist der Scheitel";
    Region: "Region" / "Bereich";
    RegionHint: "Drag an ellipse in a slice: mean, deviation, range, area" / "Ellipse in einer Schicht ziehen: Mittel, Streuung, Spanne, Fläche";
    Shape: "Shift and width" / "Verschieben, weiten";
    ShapeHint: "Drag over the 3D view: right to higher values, down wider" / "Über 3D ziehen: rechts zu höheren Werten, abwärts weiter";
    Slab: "Slab" / "Schichtdicke";
    SlabHint: "Thick slices: largest, mean or smallest value" / "Dicke Schichten: größter, mittlerer oder kleinster Wert";
    SlabThin: "Thin" / "Dünn";
    SlabMaximum: "MIP" / "MIP";
    SlabMean: "Mean" / "Mittel";
    SlabMinimum: "MinIP" / "MinIP";
    SlabThickness: "Thickness" / "Dicke";
    Mean: "Mean" / "Mittel";
    Range: "Range" / "Spanne";
    Measurement: "Measurement" / "Messung";
    Measure: "Measure" / "Messen";
    Structures: "Structures" / "Strukturen";
    StructuresFind: "Find in this scan" / "In diesem Scan finden";
    StructuresFindHint: "Of a CT: skin, bone, lungs, airways and more, by itself" / "Im CT: Haut, Knochen, Lunge, Atemwege und mehr, von selbst";
    StructuresOpen: "Open segmentation…" / "Segmentierung öffnen…";
    StructuresFolder: "Open folder of masks…" / "Ordner mit Masken öffnen…";
    StructuresHint: "A DICOM segmentation or structure set, .seg.nrrd, NIfTI or MetaImage labels, or a folder of TotalSegmentator" / "Eine DICOM-Segmentierung oder Konturen, Labels als .seg.nrrd, NIfTI oder MetaImage, oder ein Ordner von TotalSegmentator";
    StructuresAll: "All" / "Alle";
    StructuresNone: "None" / "Keine";
    StructuresRemove: "Forget" / "Vergessen";
    StructuresRest: "The rest of the scan" / "Der Rest des Scans";
    StructureNames: "Names beside the 3D picture" / "Namen neben dem 3D-Bild";
    StructureColor: "Colour" / "Farbe";
    StructureEye: "Visible" / "Sichtbar";
    StructureLook: "Look of the structure" / "Darstellung der Struktur";
    StructureAsScan: "As the scan" / "Wie der Scan";
    StructureSolid: "Solid" / "Massiv";
    StructureSpared: "Spared by cuts" / "Von Schnitten verschont";
    MeasureHint: "Choose Distance, Angle or Region above the views." / "Über den Ansichten Strecke, Winkel oder Bereich wählen.";
    MeasureFind: "Show where it is" / "Zeigen, wo sie liegt";
    Delete: "Delete" / "Löschen";
    SaveTable: "Save as CSV…" / "Als CSV speichern…";
    LayoutMain: "3D and slices" / "3D und Schichten";
    LayoutGrid: "Four views" / "Vier Ansichten";
    FrameAll: "Frame all" / "Alles zeigen";
    Front: "Front" / "Vorn";
    Left: "Left" / "Links";
    Right: "Right" / "Rechts";
    Back: "Back" / "Hinten";
    Above: "Above" / "Oben";
    Window: "Window" / "Fenster";
    Camera: "Camera" / "Kamera";
    Picture: "Picture" / "Bild";
    PictureWidth: "Width" / "Breite";
    PictureHeight: "Height" / "Höhe";
    Samples: "Samples" / "Strahlen";
    Pixels: "px" / "px";
    Transparent: "Transparent background" / "Durchsichtiger Hintergrund";
    Denoise: "Smooth noise" / "Rauschen glätten";
    SavePicture: "Save as PNG…" / "Als PNG speichern…";
    SaveTurn: "Save as PNGs…" / "Als PNGs speichern…";
    Turntable: "Turn around the scan" / "Um den Scan drehen";
    TurntableHint: "One file for each; with ffmpeg also a film" / "Je eine Datei; mit ffmpeg auch ein Film";
    Pictures: "pictures" / "Bilder";
    NoFilm: "No film: ffmpeg is not there, or failed." / "Kein Film: ffmpeg fehlt, oder es scheiterte.";
    Overwrite: "Replace these files?" / "Diese Dateien ersetzen?";
    OverwriteIt: "Replace them" / "Ersetzen";
    CopyView: "Copy view" / "Ansicht kopieren";
    Copied: "Copied to the clipboard" / "In die Zwischenablage kopiert";
    Restore: "Unsaved work" / "Ungesicherte Arbeit";
    RestoreWhy: "The Studio ended before a scene was saved. It was kept." / "Das Studio endete, bevor eine Szene gespeichert war. Sie wurde aufgehoben.";
    RestoreIt: "Restore" / "Wiederherstellen";
    Discard: "Discard" / "Verwerfen";
    Leave: "Close without saving?" / "Schließen ohne zu speichern?";
    LeaveWhy: "The scene has changes that are in no file." / "Die Szene hat Änderungen, die in keiner Datei stehen.";
    LeaveAnyway: "Close anyway" / "Trotzdem schließen";
    Replace: "Open another without saving?" / "Anderes öffnen ohne zu speichern?";
    ReplaceAnyway: "Open anyway" / "Trotzdem öffnen";
    Saved: "Saved" / "Gespeichert";
    Stopped: "It ended unexpectedly. Please try again." / "Es endete unerwartet. Bitte erneut versuchen.";
    CannotShow: "The scan cannot be shown" / "Der Scan kann nicht gezeigt werden";
    CannotOpen: "It cannot be opened" / "Es lässt sich nicht öffnen";
    CannotSave: "It cannot be saved" / "Es lässt sich nicht speichern";
    Reduced: "The GPU had no room for all voxels: the picture is of a coarser scan." / "Die Grafikkarte hat keinen Platz für alle Voxel: Das Bild zeigt einen gröberen Scan.";
    NoUnit: "value" / "Wert";
    Keys: "Keys" / "Tasten";
    KeyOpen: "Open files, a folder" / "Dateien, Ordner öffnen";
    KeySave: "Save the scene, export a picture" / "Szene speichern, Bild exportieren";
    KeyShare: "Share as a page, copy the view" / "Als Seite teilen, Ansicht kopieren";
    KeyUndo: "Undo, redo" / "Rückgängig, wiederholen";
    KeyViews: "Four views, 3D and slices, one view" / "Vier Ansichten, 3D und Schichten, eine Ansicht";
    KeyTurn: "Turn 3D, move through slices" / "3D drehen, durch Schichten gehen";
    KeyZoom: "Closer, farther, frame all" / "Näher, weiter, alles zeigen";
    Mouse: "Mouse" / "Maus";
    Mouse3D: "3D: left turns, middle moves, right zooms, a click finds the point in the slices" / "3D: links dreht, Mitte verschiebt, rechts zoomt, ein Klick findet den Punkt in den Schichten";
    Mouse2D: "Slices: left changes the window, wheel the slice, middle moves, right zooms, a click moves the cross" / "Schichten: links ändert das Fenster, das Rad die Schicht, Mitte verschiebt, rechts zoomt, ein Klick versetzt das Kreuz";
    WindowSoft: "Soft tissue" / "Weichteile";
    WindowLung: "Lung" / "Lunge";
    WindowBone: "Bone" / "Knochen";
    WindowBrain: "Brain" / "Gehirn";
    WindowVessels: "Vessels" / "Gefäße";
    WindowUsual: "Nearly all values" / "Fast alle Werte";
    WindowContrast: "More contrast" / "Mehr Kontrast";
    WindowLevel: "Level" / "Mitte";
    WindowWidth: "Width of the window" / "Breite des Fensters";
    WindowWhole: "All values" / "Alle Werte";
    Profile: "Mouse as in" / "Maus wie in";
    KeyTools: "Navigate, distance, angle, region, shift and width" / "Navigieren, Strecke, Winkel, Bereich, verschieben und weiten";
    KeyCross: "Move the cross of a slice, place a point there" / "Kreuz einer Schicht bewegen, dort einen Punkt setzen";
    KeySlices: "Oblique slice, slab, last measurement deleted" / "Schräge Schicht, Schichtdicke, letzte Messung löschen";
    MouseSlicer2D: "Slices: left moves the cross, with Ctrl changes the window, wheel the slice, middle moves, right zooms" / "Schichten: links versetzt das Kreuz, mit Strg das Fenster, das Rad die Schicht, Mitte verschiebt, rechts zoomt";
    MouseTools: "With a measuring tool the left button places points, and the right one changes the window" / "Mit einem Messwerkzeug setzt links Punkte, und rechts ändert das Fenster";
    Fingers: "Fingers: one turns 3D and leafs through slices; two move, zoom and turn" / "Finger: einer dreht 3D und blättert in Schichten; zwei verschieben, zoomen und drehen";
    LookBone: "Bone" / "Knochen";
    LookBoneGlass: "Glass bone" / "Glasknochen";
    LookSkin: "Skin" / "Haut";
    LookSoftTissue: "Organs" / "Organe";
    LookMuscle: "Muscle" / "Muskeln";
    LookFat: "Fat" / "Fett";
    LookLung: "Lung" / "Lunge";
    LookAirways: "Airways" / "Atemwege";
    LookLungVessels: "Lung vessels" / "Lungengefäße";
    LookCardiac: "Heart" / "Herz";
    LookCoronary: "Coronaries" / "Koronarien";
    LookAorta: "Aorta" / "Aorta";
    LookLiverVessels: "Liver vessels" / "Lebergefäße";
    LookAngiography: "Angiography" / "Angiographie";
    LookTeeth: "Teeth" / "Zähne";
    LookMetal: "Metal" / "Metall";
    LookXray: "X-ray" / "Röntgen";
    LookHead: "Head" / "Kopf";
    LookBrain: "Brain" / "Gehirn";
    LookMrAngiography: "Angiography" / "Angiographie";
    LookT2: "Fluid (T2)" / "Flüssigkeit (T2)";
    LookSigned: "Signed map" / "Karte um null";
    LookPet: "Uptake" / "Anreicherung";
    LookFusion: "Grey glass" / "Graues Glas";
    LookPlain: "Plain" / "Schlicht";
}

/// What a look is called.
pub fn look(preset: Preset) -> Option<Word> {
    Some(match preset {
        Preset::CtBone => Word::LookBone,
        Preset::CtBoneTranslucent => Word::LookBoneGlass,
        Preset::CtSkin => Word::LookSkin,
        Preset::CtSoftTissue => Word::LookSoftTissue,
        Preset::CtMuscle => Word::LookMuscle,
        Preset::CtFat => Word::LookFat,
        Preset::CtLung => Word::LookLung,
        Preset::CtAirways => Word::LookAirways,
        Preset::CtLungVessels => Word::LookLungVessels,
        Preset::CtCardiac => Word::LookCardiac,
        Preset::CtCoronary => Word::LookCoronary,
        Preset::CtAorta => Word::LookAorta,
        Preset::CtLiverVessels => Word::LookLiverVessels,
        Preset::CtAngiography => Word::LookAngiography,
        Preset::CtTeeth => Word::LookTeeth,
        Preset::CtMetal => Word::LookMetal,
        Preset::CtXray => Word::LookXray,
        Preset::MrHead => Word::LookHead,
        Preset::MrBrain => Word::LookBrain,
        Preset::MrAngiography => Word::LookMrAngiography,
        Preset::MrT2 => Word::LookT2,
        Preset::SignedMap => Word::LookSigned,
        Preset::PetHot => Word::LookPet,
        Preset::Fusion => Word::LookFusion,
        Preset::Plain => Word::LookPlain,
        _ => return None,
    })
}

/// What work is busy with.
pub fn stage(stage: WorkStage) -> Option<Word> {
    Some(match stage {
        WorkStage::Scanning => Word::StageScanning,
        WorkStage::Decoding => Word::StageDecoding,
        WorkStage::Generating => Word::StageGenerating,
        WorkStage::Segmenting => Word::StageSegmenting,
        WorkStage::Cutting => Word::StageCutting,
        WorkStage::Writing => Word::StageWriting,
        WorkStage::Receiving => Word::StageReceiving,
        _ => return None,
    })
}
