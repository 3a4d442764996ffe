@tool
extends Node
## Keeps scans that were imported when every zip, gz and raw file was claimed, and lets go of files that are none.
##
## Godot itself does not import these files any more. Those that it made volumes of stay volumes: they are imported again
## where what was made of them is missing, as in a fresh copy of a project, or older than they are. Those that could not
## be imported are the project's own again: what still says otherwise would keep them out of its exports.

const IMPORTER := "lumivox.volume"

var _imports := false
## When files were written last that were imported again in this session. One from the future stays newer than what is
## made of it.
var _imported: Dictionary[String, int] = {}


func _enter_tree() -> void:
	EditorInterface.get_resource_filesystem().filesystem_changed.connect(_on_filesystem_changed)


func _exit_tree() -> void:
	EditorInterface.get_resource_filesystem().filesystem_changed.disconnect(_on_filesystem_changed)


func _on_filesystem_changed() -> void:
	if _imports:
		return
	var outdated := PackedStringArray()
	_look_into(EditorInterface.get_resource_filesystem().get_filesystem(), outdated)
	if not outdated.is_empty():
		_imports = true
		EditorInterface.get_resource_filesystem().reimport_files(outdated)
		_imports = false


func _look_into(folder: EditorFileSystemDirectory, outdated: PackedStringArray) -> void:
	for i in folder.get_subdir_count():
		_look_into(folder.get_subdir(i), outdated)
	for i in folder.get_file_count():
		var path := folder.get_file_path(i)
		if not path.get_extension().to_lower() in LumivoxListedFiles.EXTENSIONS or path.to_lower().ends_with(".nii.gz"):
			continue
		var settings := ConfigFile.new()
		if not FileAccess.file_exists(path + ".import") or settings.load(path + ".import") != OK \
				or settings.get_value("remap", "importer", "") != IMPORTER:
			continue
		var made: String = settings.get_value("remap", "path", "")
		if made == "" and not FileAccess.file_exists(_made_before(path)):
			_let_go(path)
			continue
		# One that was a volume once and cannot be imported now is tried again when it has changed.
		var last := made if made != "" else path + ".import"
		var written := FileAccess.get_modified_time(path)
		var imported_of: int = _imported.get(path, -1)
		if not FileAccess.file_exists(last) or FileAccess.get_modified_time(last) < written and imported_of != written:
			_imported[path] = written
			outdated.append(path)


## Where Godot keeps what it made of a file.
static func _made_before(path: String) -> String:
	return "res://.godot/imported/%s-%s.res" % [path.get_file(), path.md5_text()]


func _let_go(path: String) -> void:
	if DirAccess.remove_absolute(path + ".import") == OK:
		print("Lumivox: %s was no scan that could be imported; it is the project's own file again." % path)
	else:
		push_warning("Lumivox: %s.import cannot be removed. Without it, %s is the project's own file again." % [
			path, path.get_file()])
