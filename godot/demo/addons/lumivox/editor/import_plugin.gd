@tool
extends EditorImportPlugin
## Imports scans that are one file whose name says so: NIfTI, NRRD, MetaImage, MGH and arrays of NumPy.
##
## Zip archives, RAW and other gz files are often a game's own: `runtime/listed_files.gd`. Those that were imported as volumes
## before stay volumes: `former_imports.gd`.

const ArrayFields := preload("array_fields.gd")
const SAVE_EXTENSION := "res"
## Those with a dot in them.
const COMPOUND_EXTENSIONS: Array[String] = ["nii.gz"]


func _get_importer_name() -> String:
	return "lumivox.volume"


func _get_visible_name() -> String:
	return "Lumivox Volume"


func _get_recognized_extensions() -> PackedStringArray:
	# Godot compares ends of names: nii.gz is not every gz.
	return PackedStringArray(["nii", "nrrd", "nhdr", "mha", "mhd", "mgh", "mgz", "npy"] + COMPOUND_EXTENSIONS)


func _get_save_extension() -> String:
	return SAVE_EXTENSION


func _get_resource_type() -> String:
	return "LumivoxVolume"


func _get_priority() -> float:
	return 1.0


func _get_format_version() -> int:
	# 4: what lies around the patient is put aside, and can be shown. 3: the patient alone, without the table.
	# 2: scans are saved with their unit, and are not called by the names of files.
	return 4


func _get_import_order() -> int:
	return ResourceImporter.IMPORT_ORDER_DEFAULT


func _can_import_threaded() -> bool:
	# A scan is decoded on all cores as it is. What saves it afterwards asks ClassDB for a class' defaults, which the
	# engine (4.6) collects without a lock: several at once would write over each other.
	return false


func _get_preset_count() -> int:
	return 0


func _get_import_options(path: String, _preset: int) -> Array[Dictionary]:
	var extension := path.get_extension().to_lower()
	var options: Array[Dictionary] = []
	if extension in ["zip", ""]:
		options.append_array(series_options())
	if extension in ["raw", "gz", ""] and not path.to_lower().ends_with(".nii.gz"):
		options.append({
			"name": "raw", "default_value": "",
			"property_hint": PROPERTY_HINT_PLACEHOLDER_TEXT, "hint_string": "256x256x108:i16le:spacing=1,1,2",
		})
	if extension in ["nhdr", "mhd", ""]:
		options.append({"name": "allow_outside_data", "default_value": false})
	if extension in ["npy", "zip", ""]:
		options.append_array(ArrayFields.dock_options())
	options.append_array(value_options())
	options.append_array(content_options())
	options.append({"name": "compress", "default_value": true})
	return options


func _get_option_visibility(_path: String, _option: StringName, _options: Dictionary) -> bool:
	return true


func _import(
		source_file: String, save_path: String, options: Dictionary,
		_platform_variants: Array[String], _gen_files: Array[String]) -> Error:
	var header := _header_of(source_file)
	if header != "":
		return save_pointer(save_path, header)
	var volume := LumivoxVolume.load_file(source_file, reader_options(options))
	if volume == null:
		var remedy := "If it is no scan, choose 'Keep File' in the Import dock."
		if source_file.get_extension().to_lower() == "raw":
			remedy = "Describe it under 'Raw' in the Import dock, or choose 'Keep File' there if it is no scan."
		push_error("Lumivox: %s was not imported; the line above says why. %s" % [source_file, remedy])
		return ERR_FILE_CORRUPT
	# Files and folders are often called by the patient's name.
	volume.resource_name = volume.get_scan_name()
	return save_volume(volume, source_file, save_path, options)


## Which of the volumes in a DICOM study is imported.
static func series_options() -> Array[Dictionary]:
	return [
		{
			"name": "series", "default_value": "",
			"property_hint": PROPERTY_HINT_PLACEHOLDER_TEXT, "hint_string": "the best",
		},
		# Of a series with several volumes, from 1; 0 is the first that is whole.
		{
			"name": "phase", "default_value": 0,
			"property_hint": PROPERTY_HINT_RANGE, "hint_string": "0,100,1,or_greater",
		},
	]


## What its values mean, in place of what the file says.
static func value_options() -> Array[Dictionary]:
	var options: Array[Dictionary] = []
	for option: String in ["slope", "intercept", "unit"]:
		options.append({
			"name": option, "default_value": "",
			"property_hint": PROPERTY_HINT_PLACEHOLDER_TEXT, "hint_string": "the file's",
		})
	options.insert(2, {
		"name": "modality", "default_value": "",
		"property_hint": PROPERTY_HINT_ENUM_SUGGESTION, "hint_string": "CT,MR,PET,other",
	})
	return options


## What of the volume is shown.
static func content_options() -> Array[Dictionary]:
	# Whether what lies around the patient in a CT (the table, clothes, cables) is a part of the scan; otherwise it is put
	# aside, for a node's `keep_everything`.
	return [{"name": "keep_everything", "default_value": false}]


## What the reader is to know of the import options.
static func reader_options(options: Dictionary) -> Dictionary:
	var wanted := {}
	for key: String in ["series", "raw", "spacing", "axes", "layout", "slope", "intercept", "modality", "unit"]:
		var text: String = options.get(key, "")
		if text.strip_edges() != "":
			wanted[key] = text.strip_edges()
	var phase: int = options.get("phase", 0)
	if phase > 0:
		wanted["phase"] = phase
	if options.get("allow_outside_data", false):
		wanted["allow_outside_data"] = true
	if options.get("keep_everything", false):
		wanted["keep_everything"] = true
	return wanted


## Writes what was imported, and tells what is worth telling.
static func save_volume(volume: LumivoxVolume, source_file: String, save_path: String, options: Dictionary) -> Error:
	var report := volume.get_report()
	for note: String in report.get("notes", PackedStringArray()):
		print("Lumivox: %s: %s" % [source_file.get_file(), note])
	var series: Array = report.get("series", [])
	if series.size() > 1 and report.get("format", "") == "DICOM":
		print("Lumivox: %s is of a study with %d series. Set 'Series' in the Import dock to take another, " % [
			source_file.get_file(), series.size()] + "or import several with Project > Tools > Import a Scan.")
	var flags := ResourceSaver.FLAG_COMPRESS if options.get("compress", true) else ResourceSaver.FLAG_NONE
	return ResourceSaver.save(volume, "%s.%s" % [save_path, SAVE_EXTENSION], flags)


## Writes, for a file that is a part of a scan, a resource that holds nothing but where the scan is.
static func save_pointer(save_path: String, series_file: String) -> Error:
	var pointer := LumivoxVolume.new()
	pointer.resource_name = "Part of a scan"
	pointer.set_meta(&"lumivox_series", series_file)
	return ResourceSaver.save(pointer, "%s.%s" % [save_path, SAVE_EXTENSION])


## The header beside a file that holds nothing but its voxels: head.mhd for head.raw and head.nhdr for head.raw.gz.
func _header_of(source_file: String) -> String:
	if not source_file.get_extension().to_lower() in ["raw", "gz"] or source_file.to_lower().ends_with(".nii.gz"):
		return ""
	var stem := source_file.get_basename().trim_suffix(".raw")
	for extension: String in ["mhd", "nhdr"]:
		if FileAccess.file_exists("%s.%s" % [stem, extension]):
			return "%s.%s" % [stem, extension]
	return ""
