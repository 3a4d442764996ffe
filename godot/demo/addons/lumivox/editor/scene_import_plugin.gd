@tool
extends EditorImportPlugin
## Imports scene files: what the command, Python or another engine saved becomes a scene like that of any model.

const SAVE_EXTENSION := "scn"


func _get_importer_name() -> String:
	return "lumivox.scene"


func _get_visible_name() -> String:
	return "Lumivox Scene"


func _get_recognized_extensions() -> PackedStringArray:
	return ["lumivox"]


func _get_save_extension() -> String:
	return SAVE_EXTENSION


func _get_resource_type() -> String:
	return "PackedScene"


func _get_priority() -> float:
	return 1.0


func _get_format_version() -> int:
	return 1


func _get_import_order() -> int:
	return ResourceImporter.IMPORT_ORDER_SCENE


func _can_import_threaded() -> bool:
	# As of scans: they are decoded on all cores as it is, and what saves them is not made for several at once.
	return false


func _get_preset_count() -> int:
	return 0


func _get_import_options(_path: String, _preset: int) -> Array[Dictionary]:
	return [
		# Whether headers such as .mhd may name data files anywhere, not only beside them or below.
		{"name": "allow_outside_data", "default_value": false},
		{"name": "compress", "default_value": true},
	]


func _get_option_visibility(_path: String, _option: StringName, _options: Dictionary) -> bool:
	return true


func _import(
		source_file: String, save_path: String, options: Dictionary,
		_platform_variants: Array[String], _gen_files: Array[String]) -> Error:
	var outside: bool = options.get("allow_outside_data", false)
	var scene := Lumivox.load_scene(source_file, outside)
	if scene == null:
		push_error("Lumivox: %s was not imported; the line above says why." % source_file)
		return ERR_FILE_CORRUPT
	var flags := ResourceSaver.FLAG_COMPRESS if options.get("compress", true) else ResourceSaver.FLAG_NONE
	return ResourceSaver.save(scene, "%s.%s" % [save_path, SAVE_EXTENSION], flags)
