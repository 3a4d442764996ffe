@tool
class_name LumivoxListedFiles
extends ResourceFormatLoader
## Has the FileSystem dock list files that may be scans, but need not be: zip, gz and raw. Nothing is made of them.
##
## Godot lists what somebody can load, and imports what ends as an import plugin says. Both together tell `head.nii.gz`,
## which is imported, from `level.gz`, which is a game's own. What is only listed is offered in the dock's menu.
##
## The engine makes one of each class like this by itself. Those that are added by hand it takes away again when it looks
## for new classes. Games load it, too, for the engine knows no difference; nothing comes of it there.

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
