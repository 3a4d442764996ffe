//! The attributes that Lumivox reads, by DICOM's own keywords (PS3.6).

use std::fmt;

/// A DICOM attribute.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Attribute {
    /// Group in the upper, element in the lower half.
    pub(crate) tag: u32,
    /// Its keyword.
    pub(crate) keyword: &'static str,
}

/// An attribute of a manufacturer's own. Which elements of its group are theirs, a creator's name says (PS3.5 7.8.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Private {
    pub(crate) group: u32,
    /// The lower half of its element; the upper one is the block's.
    pub(crate) element: u32,
    pub(crate) creator: &'static str,
    pub(crate) keyword: &'static str,
}

impl Private {
    /// The attribute where its creator has this block.
    pub(crate) fn in_block(self, block: u32) -> Attribute {
        Attribute { tag: self.group << 16 | block << 8 | self.element, keyword: self.keyword }
    }
}

impl fmt::Display for Attribute {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({:04X},{:04X})", self.keyword, self.tag >> 16, self.tag & 0xFFFF)
    }
}

macro_rules! attributes {
    ($list:ident: $($name:ident = $keyword:literal $tag:literal;)*) => {
        $(pub(crate) const $name: Attribute = Attribute { tag: $tag, keyword: $keyword };)*
        const $list: &[u32] = &[$($tag),*];
    };
}

attributes! { VALUES:
    FILE_META_INFORMATION_GROUP_LENGTH = "FileMetaInformationGroupLength" 0x0002_0000;
    TRANSFER_SYNTAX_UID = "TransferSyntaxUID" 0x0002_0010;
    SPECIFIC_CHARACTER_SET = "SpecificCharacterSet" 0x0008_0005;
    IMAGE_TYPE = "ImageType" 0x0008_0008;
    SOP_CLASS_UID = "SOPClassUID" 0x0008_0016;
    SOP_INSTANCE_UID = "SOPInstanceUID" 0x0008_0018;
    SERIES_DATE = "SeriesDate" 0x0008_0021;
    ACQUISITION_DATE = "AcquisitionDate" 0x0008_0022;
    ACQUISITION_DATE_TIME = "AcquisitionDateTime" 0x0008_002A;
    SERIES_TIME = "SeriesTime" 0x0008_0031;
    ACQUISITION_TIME = "AcquisitionTime" 0x0008_0032;
    CONTENT_TIME = "ContentTime" 0x0008_0033;
    MODALITY = "Modality" 0x0008_0060;
    CODE_VALUE = "CodeValue" 0x0008_0100;
    TIMEZONE_OFFSET_FROM_UTC = "TimezoneOffsetFromUTC" 0x0008_0201;
    STUDY_DESCRIPTION = "StudyDescription" 0x0008_1030;
    SERIES_DESCRIPTION = "SeriesDescription" 0x0008_103E;
    FRAME_TYPE = "FrameType" 0x0008_9007;
    COMPLEX_IMAGE_COMPONENT = "ComplexImageComponent" 0x0008_9208;
    ACQUISITION_CONTRAST = "AcquisitionContrast" 0x0008_9209;
    PATIENT_NAME = "PatientName" 0x0010_0010;
    PATIENT_ID = "PatientID" 0x0010_0020;
    PATIENT_WEIGHT = "PatientWeight" 0x0010_1030;
    CONTRAST_BOLUS_AGENT = "ContrastBolusAgent" 0x0018_0010;
    BODY_PART_EXAMINED = "BodyPartExamined" 0x0018_0015;
    SLICE_THICKNESS = "SliceThickness" 0x0018_0050;
    ECHO_TIME = "EchoTime" 0x0018_0081;
    SPACING_BETWEEN_SLICES = "SpacingBetweenSlices" 0x0018_0088;
    ECHO_NUMBERS = "EchoNumbers" 0x0018_0086;
    SCANNING_SEQUENCE = "ScanningSequence" 0x0018_0020;
    SEQUENCE_VARIANT = "SequenceVariant" 0x0018_0021;
    ANGIO_FLAG = "AngioFlag" 0x0018_0025;
    REPETITION_TIME = "RepetitionTime" 0x0018_0080;
    INVERSION_TIME = "InversionTime" 0x0018_0082;
    TRIGGER_TIME = "TriggerTime" 0x0018_1060;
    FRAME_TIME = "FrameTime" 0x0018_1063;
    FRAME_TIME_VECTOR = "FrameTimeVector" 0x0018_1065;
    ACTUAL_FRAME_DURATION = "ActualFrameDuration" 0x0018_1242;
    NOMINAL_SCANNED_PIXEL_SPACING = "NominalScannedPixelSpacing" 0x0018_2010;
    FRAME_ACQUISITION_DATE_TIME = "FrameAcquisitionDateTime" 0x0018_9074;
    RADIOPHARMACEUTICAL_START_TIME = "RadiopharmaceuticalStartTime" 0x0018_1072;
    RADIONUCLIDE_TOTAL_DOSE = "RadionuclideTotalDose" 0x0018_1074;
    RADIONUCLIDE_HALF_LIFE = "RadionuclideHalfLife" 0x0018_1075;
    RADIOPHARMACEUTICAL_START_DATE_TIME = "RadiopharmaceuticalStartDateTime" 0x0018_1078;
    PROTOCOL_NAME = "ProtocolName" 0x0018_1030;
    CONVOLUTION_KERNEL = "ConvolutionKernel" 0x0018_1210;
    SLICE_LOCATION_VECTOR = "SliceLocationVector" 0x0018_2005;
    EFFECTIVE_ECHO_TIME = "EffectiveEchoTime" 0x0018_9082;
    DIFFUSION_B_VALUE = "DiffusionBValue" 0x0018_9087;
    DECAY_CORRECTION_DATE_TIME = "DecayCorrectionDateTime" 0x0018_9701;
    DECAY_CORRECTED = "DecayCorrected" 0x0018_9758;
    ATTENUATION_CORRECTED = "AttenuationCorrected" 0x0018_9759;
    IMAGER_PIXEL_SPACING = "ImagerPixelSpacing" 0x0018_1164;
    SERIES_INSTANCE_UID = "SeriesInstanceUID" 0x0020_000E;
    SERIES_NUMBER = "SeriesNumber" 0x0020_0011;
    ACQUISITION_NUMBER = "AcquisitionNumber" 0x0020_0012;
    INSTANCE_NUMBER = "InstanceNumber" 0x0020_0013;
    IMAGE_POSITION_PATIENT = "ImagePositionPatient" 0x0020_0032;
    IMAGE_ORIENTATION_PATIENT = "ImageOrientationPatient" 0x0020_0037;
    IMAGE_POSITION_VOLUME = "ImagePositionVolume" 0x0020_9301;
    IMAGE_ORIENTATION_VOLUME = "ImageOrientationVolume" 0x0020_9302;
    FRAME_OF_REFERENCE_UID = "FrameOfReferenceUID" 0x0020_0052;
    TEMPORAL_POSITION_IDENTIFIER = "TemporalPositionIdentifier" 0x0020_0100;
    IN_STACK_POSITION_NUMBER = "InStackPositionNumber" 0x0020_9057;
    TEMPORAL_POSITION_INDEX = "TemporalPositionIndex" 0x0020_9128;
    NOMINAL_CARDIAC_TRIGGER_DELAY_TIME = "NominalCardiacTriggerDelayTime" 0x0020_9153;
    FRAME_ACQUISITION_NUMBER = "FrameAcquisitionNumber" 0x0020_9156;
    DIMENSION_ORGANIZATION_TYPE = "DimensionOrganizationType" 0x0020_9311;
    SAMPLES_PER_PIXEL = "SamplesPerPixel" 0x0028_0002;
    PHOTOMETRIC_INTERPRETATION = "PhotometricInterpretation" 0x0028_0004;
    NUMBER_OF_FRAMES = "NumberOfFrames" 0x0028_0008;
    FRAME_INCREMENT_POINTER = "FrameIncrementPointer" 0x0028_0009;
    ROWS = "Rows" 0x0028_0010;
    COLUMNS = "Columns" 0x0028_0011;
    PIXEL_SPACING = "PixelSpacing" 0x0028_0030;
    CORRECTED_IMAGE = "CorrectedImage" 0x0028_0051;
    BITS_ALLOCATED = "BitsAllocated" 0x0028_0100;
    BITS_STORED = "BitsStored" 0x0028_0101;
    HIGH_BIT = "HighBit" 0x0028_0102;
    PIXEL_REPRESENTATION = "PixelRepresentation" 0x0028_0103;
    SMALLEST_IMAGE_PIXEL_VALUE = "SmallestImagePixelValue" 0x0028_0106;
    PIXEL_PADDING_VALUE = "PixelPaddingValue" 0x0028_0120;
    PIXEL_PADDING_RANGE_LIMIT = "PixelPaddingRangeLimit" 0x0028_0121;
    FLOAT_PIXEL_PADDING_VALUE = "FloatPixelPaddingValue" 0x0028_0122;
    DOUBLE_FLOAT_PIXEL_PADDING_VALUE = "DoubleFloatPixelPaddingValue" 0x0028_0123;
    WINDOW_CENTER = "WindowCenter" 0x0028_1050;
    RESCALE_INTERCEPT = "RescaleIntercept" 0x0028_1052;
    RESCALE_SLOPE = "RescaleSlope" 0x0028_1053;
    RESCALE_TYPE = "RescaleType" 0x0028_1054;
    RED_PALETTE_DESCRIPTOR = "RedPaletteColorLookupTableDescriptor" 0x0028_1101;
    GREEN_PALETTE_DESCRIPTOR = "GreenPaletteColorLookupTableDescriptor" 0x0028_1102;
    BLUE_PALETTE_DESCRIPTOR = "BluePaletteColorLookupTableDescriptor" 0x0028_1103;
    RED_PALETTE_DATA = "RedPaletteColorLookupTableData" 0x0028_1201;
    GREEN_PALETTE_DATA = "GreenPaletteColorLookupTableData" 0x0028_1202;
    BLUE_PALETTE_DATA = "BluePaletteColorLookupTableData" 0x0028_1203;
    LUT_DESCRIPTOR = "LUTDescriptor" 0x0028_3002;
    MODALITY_LUT_TYPE = "ModalityLUTType" 0x0028_3004;
    LUT_DATA = "LUTData" 0x0028_3006;
    REAL_WORLD_VALUE_LAST_VALUE_MAPPED = "RealWorldValueLastValueMapped" 0x0040_9211;
    DOUBLE_FLOAT_REAL_WORLD_VALUE_LAST_VALUE_MAPPED = "DoubleFloatRealWorldValueLastValueMapped" 0x0040_9213;
    DOUBLE_FLOAT_REAL_WORLD_VALUE_FIRST_VALUE_MAPPED = "DoubleFloatRealWorldValueFirstValueMapped" 0x0040_9214;
    REAL_WORLD_VALUE_FIRST_VALUE_MAPPED = "RealWorldValueFirstValueMapped" 0x0040_9216;
    REAL_WORLD_VALUE_INTERCEPT = "RealWorldValueIntercept" 0x0040_9224;
    REAL_WORLD_VALUE_SLOPE = "RealWorldValueSlope" 0x0040_9225;
    ENERGY_WINDOW_VECTOR = "EnergyWindowVector" 0x0054_0010;
    DETECTOR_VECTOR = "DetectorVector" 0x0054_0020;
    PHASE_VECTOR = "PhaseVector" 0x0054_0030;
    RR_INTERVAL_VECTOR = "RRIntervalVector" 0x0054_0060;
    TIME_SLOT_VECTOR = "TimeSlotVector" 0x0054_0070;
    SLICE_VECTOR = "SliceVector" 0x0054_0080;
    TIME_SLICE_VECTOR = "TimeSliceVector" 0x0054_0100;
    UNITS = "Units" 0x0054_1001;
    SUV_TYPE = "SUVType" 0x0054_1006;
    DECAY_CORRECTION = "DecayCorrection" 0x0054_1102;
    FRAME_REFERENCE_TIME = "FrameReferenceTime" 0x0054_1300;
    ROI_NUMBER = "ROINumber" 0x3006_0022;
    ROI_NAME = "ROIName" 0x3006_0026;
    ROI_DISPLAY_COLOR = "ROIDisplayColor" 0x3006_002A;
    CONTOUR_GEOMETRIC_TYPE = "ContourGeometricType" 0x3006_0042;
    CONTOUR_DATA = "ContourData" 0x3006_0050;
    REFERENCED_ROI_NUMBER = "ReferencedROINumber" 0x3006_0084;
    SEGMENTATION_TYPE = "SegmentationType" 0x0062_0001;
    SEGMENT_NUMBER = "SegmentNumber" 0x0062_0004;
    SEGMENT_LABEL = "SegmentLabel" 0x0062_0005;
    RECOMMENDED_DISPLAY_CIELAB_VALUE = "RecommendedDisplayCIELabValue" 0x0062_000D;
    REFERENCED_SEGMENT_NUMBER = "ReferencedSegmentNumber" 0x0062_000B;
    MAXIMUM_FRACTIONAL_VALUE = "MaximumFractionalValue" 0x0062_000E;
    DOSE_UNITS = "DoseUnits" 0x3004_0002;
    GRID_FRAME_OFFSET_VECTOR = "GridFrameOffsetVector" 0x3004_000C;
    DOSE_GRID_SCALING = "DoseGridScaling" 0x3004_000E;
    OVERLAY_BIT_POSITION = "OverlayBitPosition" 0x6000_0102;
    EXTENDED_OFFSET_TABLE = "ExtendedOffsetTable" 0x7FE0_0001;
}

attributes! { SEQUENCES:
    REFERENCED_SERIES_SEQUENCE = "ReferencedSeriesSequence" 0x0008_1115;
    MR_ECHO_SEQUENCE = "MREchoSequence" 0x0018_9114;
    MR_DIFFUSION_SEQUENCE = "MRDiffusionSequence" 0x0018_9117;
    CARDIAC_SYNCHRONIZATION_SEQUENCE = "CardiacSynchronizationSequence" 0x0018_9118;
    MR_IMAGE_FRAME_TYPE_SEQUENCE = "MRImageFrameTypeSequence" 0x0018_9226;
    CT_IMAGE_FRAME_TYPE_SEQUENCE = "CTImageFrameTypeSequence" 0x0018_9329;
    PET_FRAME_TYPE_SEQUENCE = "PETFrameTypeSequence" 0x0018_9751;
    FRAME_CONTENT_SEQUENCE = "FrameContentSequence" 0x0020_9111;
    PLANE_POSITION_SEQUENCE = "PlanePositionSequence" 0x0020_9113;
    PLANE_ORIENTATION_SEQUENCE = "PlaneOrientationSequence" 0x0020_9116;
    PLANE_POSITION_VOLUME_SEQUENCE = "PlanePositionVolumeSequence" 0x0020_930E;
    PLANE_ORIENTATION_VOLUME_SEQUENCE = "PlaneOrientationVolumeSequence" 0x0020_930F;
    MODALITY_LUT_SEQUENCE = "ModalityLUTSequence" 0x0028_3000;
    MEASUREMENT_UNITS_CODE_SEQUENCE = "MeasurementUnitsCodeSequence" 0x0040_08EA;
    REAL_WORLD_VALUE_MAPPING_SEQUENCE = "RealWorldValueMappingSequence" 0x0040_9096;
    RADIOPHARMACEUTICAL_INFORMATION_SEQUENCE = "RadiopharmaceuticalInformationSequence" 0x0054_0016;
    DETECTOR_INFORMATION_SEQUENCE = "DetectorInformationSequence" 0x0054_0022;
    STRUCTURE_SET_ROI_SEQUENCE = "StructureSetROISequence" 0x3006_0020;
    ROI_CONTOUR_SEQUENCE = "ROIContourSequence" 0x3006_0039;
    CONTOUR_SEQUENCE = "ContourSequence" 0x3006_0040;
    SEGMENT_SEQUENCE = "SegmentSequence" 0x0062_0002;
    SEGMENT_IDENTIFICATION_SEQUENCE = "SegmentIdentificationSequence" 0x0062_000A;
    PIXEL_MEASURES_SEQUENCE = "PixelMeasuresSequence" 0x0028_9110;
    PIXEL_VALUE_TRANSFORMATION_SEQUENCE = "PixelValueTransformationSequence" 0x0028_9145;
    UNASSIGNED_SHARED_CONVERTED_ATTRIBUTES_SEQUENCE =
        "UnassignedSharedConvertedAttributesSequence" 0x0020_9170;
    UNASSIGNED_PER_FRAME_CONVERTED_ATTRIBUTES_SEQUENCE =
        "UnassignedPerFrameConvertedAttributesSequence" 0x0020_9171;
    SHARED_FUNCTIONAL_GROUPS_SEQUENCE = "SharedFunctionalGroupsSequence" 0x5200_9229;
    PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE = "PerFrameFunctionalGroupsSequence" 0x5200_9230;
}

pub(crate) const SIEMENS_B_VALUE: Private =
    Private { group: 0x0019, element: 0x0C, creator: "SIEMENS MR HEADER", keyword: "B_value" };
pub(crate) const SIEMENS_CSA_HEADER: Private =
    Private { group: 0x0029, element: 0x10, creator: "SIEMENS CSA HEADER", keyword: "CSAImageHeaderInfo" };
/// Four numbers, of which the first is the b-value, sometimes with 1,000,000,000 added.
pub(crate) const GE_B_VALUE: Private =
    Private { group: 0x0043, element: 0x39, creator: "GEMS_PARM_01", keyword: "B_value" };
/// What an image is a part of: 0 magnitude, 1 phase, 2 real, 3 imaginary.
pub(crate) const GE_IMAGE_PART: Private =
    Private { group: 0x0043, element: 0x2F, creator: "GEMS_PARM_01", keyword: "RawDataTypeImageType" };
/// 2 for magnitudes beside maps and flow, 3 to 5 for directions.
pub(crate) const GE_VAS_COLLAPSE: Private =
    Private { group: 0x0043, element: 0x30, creator: "GEMS_PARM_01", keyword: "VasCollapseFlag" };
pub(crate) const PHILIPS_B_VALUE: Private =
    Private { group: 0x2001, element: 0x03, creator: "Philips Imaging DD 001", keyword: "DiffusionBFactor" };
/// The protocol of a whole series, as text between binary data.
pub(crate) const SIEMENS_CSA_SERIES_HEADER: Private =
    Private { group: 0x0029, element: 0x20, creator: "SIEMENS CSA HEADER", keyword: "CSASeriesHeaderInfo" };
/// When the scan of a PET series began, whenever the series was made.
pub(crate) const GE_SCAN_DATE_TIME: Private =
    Private { group: 0x0009, element: 0x0D, creator: "GEMS_PETD_01", keyword: "ScanDateTime" };
/// What makes SUV of counts.
pub(crate) const PHILIPS_SUV_SCALE: Private =
    Private { group: 0x7053, element: 0x00, creator: "Philips PET Private Group", keyword: "SUVScaleFactor" };
/// What makes Bq/ml of counts.
pub(crate) const PHILIPS_ACTIVITY_SCALE: Private = Private {
    group: 0x7053,
    element: 0x09,
    creator: "Philips PET Private Group",
    keyword: "ActivityConcentrationScaleFactor",
};
/// Slices of a picture that is a grid of them.
pub(crate) const UIH_SLICES: Private = Private {
    group: 0x0065,
    element: 0x50,
    creator: "Image Private Header",
    keyword: "MRNumberOfSliceInVolume",
};
/// An item for each of them.
pub(crate) const UIH_FRAME_SEQUENCE: Private =
    Private { group: 0x0065, element: 0x51, creator: "Image Private Header", keyword: "MRVFrameSequence" };
const PRIVATE: [Private; 11] = [
    SIEMENS_B_VALUE,
    SIEMENS_CSA_HEADER,
    SIEMENS_CSA_SERIES_HEADER,
    GE_B_VALUE,
    GE_IMAGE_PART,
    GE_VAS_COLLAPSE,
    GE_SCAN_DATE_TIME,
    PHILIPS_B_VALUE,
    PHILIPS_SUV_SCALE,
    PHILIPS_ACTIVITY_SCALE,
    UIH_SLICES,
];

pub(crate) const FLOAT_PIXEL_DATA: Attribute = Attribute { tag: 0x7FE0_0008, keyword: "FloatPixelData" };
pub(crate) const DOUBLE_FLOAT_PIXEL_DATA: Attribute =
    Attribute { tag: 0x7FE0_0009, keyword: "DoubleFloatPixelData" };
pub(crate) const PIXEL_DATA: Attribute = Attribute { tag: 0x7FE0_0010, keyword: "PixelData" };

/// Whether a value of `tag` is kept when a header is read.
pub(crate) fn is_wanted_value(tag: u32) -> bool {
    // Creators come before what is theirs, so that these are kept too.
    let (group, element) = (tag >> 16, tag & 0xFFFF);
    let is_private = |private: &Private| {
        group == private.group
            && ((0x10..=0xFF).contains(&element) || element >= 0x1000 && element & 0xFF == private.element)
    };
    VALUES.contains(&tag) || group % 2 == 1 && PRIVATE.iter().any(is_private)
}

/// Whether the items of sequence `tag` are read, not skipped.
pub(crate) fn is_wanted_sequence(tag: u32) -> bool {
    let uih = UIH_FRAME_SEQUENCE;
    SEQUENCES.contains(&tag)
        || tag >> 16 == uih.group && (tag & 0xFFFF) >= 0x1000 && tag & 0xFF == uih.element
}
