@tool
extends ResourceFormatLoader
## Has the FileSystem dock list files that may be scans, but need not be: zip, gz and raw. Nothing is made of them.
##
## Godot lists what somebody can load, and imports what ends as an import plugin says. Both together tell `head.nii.gz`,
## which is imported, from `level.gz`, which is a game's own. What is only listed is offered in the dock's menu.

## Whose endings say too little.
const EXTENSIONS: PackedStringArray = ["zip", "gz", "raw"]
## What Godot lists, and exports only where a filter of the preset says so.
const LISTED_ONLY := "TextFile"


func _get_recognized_extensions() -> PackedStringArray:
	return EXTENSIONS


func _recognize_path(_path: String, _type: StringName) -> bool:
	return false


func _handles_type(_type: StringName) -> bool:
	return false


func _get_resource_type(path: String) -> String:
	return LISTED_ONLY if path.get_extension().to_lower() in EXTENSIONS else ""
