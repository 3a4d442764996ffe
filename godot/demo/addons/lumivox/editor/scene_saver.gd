@tool
extends Node
## Saves what the editor's 3D view shows as a scene file, which Lumivox' command, Python and other engines render.

var _files := EditorFileDialog.new()
var _problem := AcceptDialog.new()


func _init() -> void:
	_files.title = "Save View as Scene"
	_files.file_mode = EditorFileDialog.FILE_MODE_SAVE_FILE
	# Scenes may lie beside their scans, and those anywhere.
	_files.access = EditorFileDialog.ACCESS_FILESYSTEM
	_files.add_filter("*.lumivox", "Lumivox scenes")
	_files.file_selected.connect(save)
	_problem.title = "Save View as Scene"
	_problem.dialog_autowrap = true
	add_child(_files)
	add_child(_problem)


## Asks for the file.
func open() -> void:
	_files.current_path = ProjectSettings.globalize_path("res://").path_join("view.lumivox")
	_files.popup_file_dialog()


## Saves the first 3D view, whose camera is the picture's. Returns what went wrong, if anything.
func save(path: String) -> String:
	var problem := Lumivox.save_scene(EditorInterface.get_editor_viewport_3d(0), path)
	if problem != "":
		push_error("Lumivox: %s was not saved: %s." % [path, problem])
		_problem.dialog_text = "The view was not saved: %s." % problem
		_problem.popup_centered(Vector2i(480, 0))
		return problem
	print("Lumivox: the view was saved as %s." % path)
	if ProjectSettings.localize_path(path).begins_with("res://"):
		EditorInterface.get_resource_filesystem().scan()
	return ""
