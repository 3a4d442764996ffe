@tool
extends "import_plugin.gd"
## Imports DICOM files: a folder of slices is one scan, which is imported with its first file.
##
## The folder's other files become resources that hold nothing but where the scan is. When files come later or go,
## `dicom_folders.gd` imports the folder again.

const DicomFolders := preload("dicom_folders.gd")

## Metadata of a file that is a part of a scan: the file that the scan was imported with.
const SERIES_META := &"lumivox_series"


func _get_importer_name() -> String:
	return "lumivox.dicom"


func _get_visible_name() -> String:
	return "Lumivox DICOM Series"


func _get_recognized_extensions() -> PackedStringArray:
	return ["dcm", "dicom"]


func _get_format_version() -> int:
	# 5: what lies around the patient is put aside, and can be shown. 4: the patient alone, without the table.
	# 3: scans are saved with their unit, and are not called by the names of folders.
	return 5


func _get_import_options(_path: String, _preset: int) -> Array[Dictionary]:
	return series_options() + value_options() + content_options() \
			+ ([{"name": "compress", "default_value": true}] as Array[Dictionary])


func _import(
		source_file: String, save_path: String, options: Dictionary,
		_platform_variants: Array[String], _gen_files: Array[String]) -> Error:
	var folder := source_file.get_base_dir()
	var first := DicomFolders.first_file(folder)
	if source_file != first:
		DicomFolders.touch(source_file)
		return save_pointer(save_path, first)
	DicomFolders.remember(folder, first, options)
	var volume := LumivoxVolume.load_file(folder, reader_options(options))
	if volume == null:
		push_error("Lumivox: %s was not imported; the line above says why." % folder)
		return ERR_FILE_CORRUPT
	volume.resource_name = volume.get_scan_name()
	return save_volume(volume, source_file, save_path, options)
