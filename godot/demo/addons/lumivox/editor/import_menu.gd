@tool
extends EditorContextMenuPlugin
## 'Import as Lumivox Volume' in the FileSystem dock: for what is not imported by itself.

## Emitted with the file or folder that was chosen.
signal chosen(path: String)

const ITEM := "Import as Lumivox Volume..."

var _offered := ""


func _popup_menu(paths: PackedStringArray) -> void:
	if paths.size() == 1 and is_offered(paths[0]):
		_offered = paths[0]
		# No closure: this holds the item, which would hold this.
		add_context_menu_item(ITEM, _on_chosen)


func _on_chosen(_paths: Variant) -> void:
	chosen.emit(_offered)


## Whether a path may lead to a scan that Godot does not import by itself.
static func is_offered(path: String) -> bool:
	if DirAccess.dir_exists_absolute(path):
		return true
	return path.get_extension().to_lower() in LumivoxListedFiles.EXTENSIONS and not path.to_lower().ends_with(".nii.gz")
