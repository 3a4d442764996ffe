@tool
extends "import_plugin.gd"
## Imports DICOM files: a folder of slices is one scan, which is imported with its first file.
##
## The folder's other files become resources that hold nothing but where the scan is.

## Metadata of a file that is a part of a scan: the file that the scan was imported with.
const SERIES_META := &"lumivox_series"

static var _first_files: Dictionary[String, String] = {}


func _get_importer_name() -> String:
	return "lumivox.dicom"


func _get_visible_name() -> String:
	return "Lumivox DICOM Series"


func _get_recognized_extensions() -> PackedStringArray:
	return ["dcm", "dicom"]


func _get_import_options(_path: String, _preset: int) -> Array[Dictionary]:
	return series_options() + ([{"name": "compress", "default_value": true}] as Array[Dictionary])


func _import(
		source_file: String, save_path: String, options: Dictionary,
		_platform_variants: Array[String], _gen_files: Array[String]) -> Error:
	var folder := source_file.get_base_dir()
	var first := first_file(folder)
	if source_file != first:
		return save_pointer(save_path, first)
	var volume := LumivoxVolume.load_file(folder, reader_options(options))
	if volume == null:
		push_error("Lumivox: %s was not imported; the line above says why." % folder)
		return ERR_FILE_CORRUPT
	volume.resource_name = folder.get_file()
	return save_volume(volume, source_file, save_path, options)


## The file that a folder's scan is imported with: its first one by name.
static func first_file(folder: String) -> String:
	if not _first_files.has(folder):
		# Listed once: a scan may have thousands of files, and each asks.
		var names: Array[String] = []
		for name in DirAccess.get_files_at(folder):
			if name.get_extension().to_lower() in ["dcm", "dicom"]:
				names.append(name)
		names.sort_custom(func(a: String, b: String) -> bool: return a.naturalnocasecmp_to(b) < 0)
		_first_files[folder] = folder.path_join(names[0]) if not names.is_empty() else ""
	return _first_files[folder]


## Files were added or removed.
static func forget_folders() -> void:
	_first_files.clear()
