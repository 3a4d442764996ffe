//! What is in files, before and while it is loaded.

use std::path::{Path, PathBuf};

use lumivox_core::{CancelToken, Progress};

use crate::{
    ImportOptions, ImportReport, Imported, SeriesSummary, Thumbnail,
    choice::{channel, format_of, only_volume_in, unused},
    dicom,
    error::ImportError,
    format::{self, Format},
    labels::{
        self,
        segments::{self, Segment},
    },
    metaimage, mgh, nifti, npy, nrrd, pictures, raw,
    single::Single,
    source,
    values::Told,
    zarr,
};

/// Files whose headers were read: what can be loaded from them, and why others cannot.
///
/// A front end opens a study, shows its report and thumbnails, and loads what the user picks; headers are read once.
/// ```no_run
/// use lumivox_core::{CancelToken, Progress};
/// use lumivox_import::{ImportOptions, Study};
///
/// let (mut options, cancel) = (ImportOptions::default(), CancelToken::new());
/// let mut study = Study::open(&["folder".into()], &options, Progress::SILENT, &cancel)?;
/// for (place, series) in study.report().series.iter().enumerate() {
///     let thumbnail = study.thumbnail(place, 128, &cancel)?;
///     println!("{} {} ({} x {} pixels)", place + 1, series.description, thumbnail.width, thumbnail.height);
/// }
/// options.series = Some("2".to_owned());
/// let volume = study.load(&options, Progress::SILENT, &cancel)?.volume;
/// # Ok::<(), lumivox_import::ImportError>(())
/// ```
pub struct Study {
    content: Content,
    report: ImportReport,
    paths: Vec<PathBuf>,
}

enum Content {
    Dicom(Box<dicom::Study>),
    /// A file of another format, which holds one scan.
    Single(Box<Single>),
    /// The channels of an image, at least one.
    Channels(Vec<Single>),
    /// A segmentation whose segments lie in several layers.
    Layers(Box<Single>, Vec<Segment>),
}

impl Study {
    /// Reads the headers of one file of any format, a folder, a zip archive, or several DICOM files. No pixel is read, but
    /// the sizes of files are compared with what their headers promise.
    ///
    /// A folder is a DICOM study with all that is in it; one without any DICOM may hold one volume of another format.
    /// One with DICOM but without a single series is a study with an empty list.
    ///
    /// # Errors
    /// [`ImportError`] names the file, what is wrong and what to do.
    pub fn open(
        paths: &[PathBuf],
        options: &ImportOptions,
        progress: Progress<'_>,
        cancel: &CancelToken,
    ) -> Result<Self, ImportError> {
        let study = Self::read_headers(paths, options, progress, cancel)?;
        Ok(Self { paths: paths.to_vec(), ..study })
    }

    fn read_headers(
        paths: &[PathBuf],
        options: &ImportOptions,
        progress: Progress<'_>,
        cancel: &CancelToken,
    ) -> Result<Self, ImportError> {
        let dicom = |mut study: dicom::Study| {
            let mut report = study.report(options)?;
            report.notes.extend(unused(options, &report.format));
            Ok(Self { content: Content::Dicom(Box::new(study)), report, paths: vec![] })
        };
        let single = |file: &Path| {
            let format = format_of(file, options)?;
            if format == Format::Tiff {
                return Self::of_channels(pictures::open_tiff(file, options, cancel)?, options);
            }
            let single = match (format, &options.raw) {
                (Format::Dicom | Format::Zip, _) => {
                    return dicom(dicom::Study::open(&[file.to_owned()], progress, cancel)?);
                }
                (Format::Nifti, _) => nifti::open(file),
                (Format::Nrrd, _) => nrrd::open(file, options.allow_outside_data),
                (Format::MetaImage, _) => metaimage::open(file, options.allow_outside_data),
                (Format::Mgh, _) => mgh::open(file),
                (Format::Npy, _) => npy::open(file, options),
                (Format::Tiff, _) => unreachable!("it has channels"),
                (Format::Raw, Some(description)) => raw::open_as(file, description),
                (Format::Raw, None) => raw::open(file),
            }?;
            let mut report = single.report();
            report.notes.extend(unused(options, &report.format));
            let segments = match single.format {
                nrrd::NAME if single.phases > 1 => segments::read(file, options.allow_outside_data)?,
                _ => Vec::new(),
            };
            if segments.is_empty() {
                return Ok(Self { content: Content::Single(Box::new(single)), report, paths: vec![] });
            }
            // All its layers are one picture.
            report.series.iter_mut().for_each(|series| series.phases = 1);
            Ok(Self { content: Content::Layers(Box::new(single), segments), report, paths: vec![] })
        };
        match paths {
            [folder] if crate::files::is_dir(folder) && zarr::is_zarr(folder) => {
                Self::of_channels(zarr::open(folder, options, cancel)?, options)
            }
            [folder] if crate::files::is_dir(folder) => {
                let study = dicom::Study::open(paths, progress, cancel)?;
                if study.is_dicom() {
                    return dicom(study);
                }
                match only_volume_in(folder, options, cancel) {
                    Ok(file) => single(&file),
                    Err(error @ ImportError::NoSeries { .. }) => {
                        let files = dicom::files_below(folder, cancel)?.files;
                        Self::of_pictures(&files, options, cancel)?
                            .ok_or_else(|| pictures::beside_others(folder, &files).unwrap_or(error))
                    }
                    Err(error) => Err(error),
                }
            }
            [file] => single(file),
            _ => match Self::of_pictures(paths, options, cancel)? {
                Some(study) => Ok(study),
                None => dicom(dicom::Study::open(paths, progress, cancel)?),
            },
        }
    }

    /// A stack of pictures, if files are that and nothing else.
    fn of_pictures(
        files: &[PathBuf],
        options: &ImportOptions,
        cancel: &CancelToken,
    ) -> Result<Option<Self>, ImportError> {
        if let [only] = files {
            return match format::recognise(only) {
                Ok(Format::Tiff) => {
                    Self::of_channels(pictures::open_tiff(only, options, cancel)?, options).map(Some)
                }
                _ => Ok(None),
            };
        }
        let single = pictures::open_slices(files, options, cancel)?;
        single.map(|single| Self::of_channels(vec![single], options)).transpose()
    }

    /// An image of one channel or several, each of which is a series.
    fn of_channels(channels: Vec<Single>, options: &ImportOptions) -> Result<Self, ImportError> {
        let chosen = channel(&channels, options)?;
        let mut report = channels[chosen].report();
        if channels.len() > 1 {
            let n = channels.len();
            let of = |(k, channel): (usize, &Single)| {
                let mut series = channel.report().series.remove(0);
                series.description = format!("{}, channel {} of {n}", series.description, k + 1);
                series.reason =
                    if k == 0 { String::new() } else { "another channel of the same image".to_owned() };
                series
            };
            report.series = channels.iter().enumerate().map(of).collect();
            report.chosen = chosen;
        }
        Ok(Self { content: Content::Channels(channels), report, paths: vec![] })
    }

    /// What was found; [`ImportReport::chosen`] and [`ImportReport::notes`] are of the series that the options of
    /// [`Study::open`] name.
    pub fn report(&self) -> &ImportReport {
        &self.report
    }

    /// A picture of the middle slice of series `place` (from 0) of the report, at most `side` pixels wide and high.
    ///
    /// # Errors
    /// When no slice near the middle can be decoded, and on cancel.
    ///
    /// # Panics
    /// When there is no such series.
    pub fn thumbnail(
        &self,
        place: usize,
        side: usize,
        cancel: &CancelToken,
    ) -> Result<Thumbnail, ImportError> {
        assert!(place < self.report.series.len(), "there is no series {place}");
        match &self.content {
            Content::Dicom(study) => study.thumbnail(place, side, cancel),
            Content::Channels(channels) => channels[place].thumbnail(side, cancel),
            Content::Single(single) | Content::Layers(single, _) => single.thumbnail(side, cancel),
        }
    }

    /// Loads the series and phase that `options` name; by default the first series, which is the best.
    ///
    /// # Errors
    /// [`ImportError`] names the file, what is wrong and what to do.
    pub fn load(
        &mut self,
        options: &ImportOptions,
        progress: Progress<'_>,
        cancel: &CancelToken,
    ) -> Result<Imported, ImportError> {
        let imported = self.load_content(options, progress, cancel)?;
        let source = source::scan(&self.paths, options, &imported.report);
        Ok(Imported { volume: imported.volume.with_source(source), ..imported })
    }

    fn load_content(
        &mut self,
        options: &ImportOptions,
        progress: Progress<'_>,
        cancel: &CancelToken,
    ) -> Result<Imported, ImportError> {
        let mut imported = match &mut self.content {
            Content::Dicom(study) => study.load(options, progress, cancel)?,
            Content::Layers(single, segments) if options.phase.is_none() => {
                // It has told of unused options by itself.
                return labels::load_layers(single, segments, options, progress, cancel);
            }
            Content::Single(single) | Content::Layers(single, _) => {
                single.load(options.phase, &Told::by(options), progress, cancel)?
            }
            Content::Channels(channels) => {
                let chosen = channel(channels, options)?;
                let mut imported =
                    channels[chosen].load(options.phase, &Told::by(options), progress, cancel)?;
                if channels.len() > 1 {
                    let own = imported.report.series.remove(0);
                    imported.report.series.clone_from(&self.report.series);
                    let described = imported.report.series[chosen].description.clone();
                    imported.report.series[chosen] = SeriesSummary { description: described, ..own };
                    imported.report.chosen = chosen;
                }
                imported
            }
        };
        imported.report.notes.extend(unused(options, &imported.report.format));
        Ok(imported)
    }
}

/// Says what is in `paths` without reading a pixel: the report of [`Study::open`].
///
/// # Errors
/// As [`Study::open`].
pub fn scan(
    paths: &[PathBuf],
    options: &ImportOptions,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<ImportReport, ImportError> {
    Ok(Study::open(paths, options, progress, cancel)?.report)
}

/// Loads the volume in `paths`: one file of any format, a folder, a zip archive, or several DICOM files.
///
/// A folder is a DICOM study with all that is in it; one without any DICOM may hold one volume of another format. Of
/// several series the best is loaded (with depth, then CT, MR or PET, then the most voxels), unless
/// [`ImportOptions::series`] names another; of several phases the first that is whole, or [`ImportOptions::phase`].
///
/// # Errors
/// [`ImportError`] names the file, what is wrong and what to do.
pub fn load(
    paths: &[PathBuf],
    options: &ImportOptions,
    progress: Progress<'_>,
    cancel: &CancelToken,
) -> Result<Imported, ImportError> {
    Study::open(paths, options, progress, cancel)?.load(options, progress, cancel)
}
