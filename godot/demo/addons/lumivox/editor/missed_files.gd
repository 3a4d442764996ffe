@tool
extends Node
## Has scans imported that the engine passes by when it meets their importer for the first time.
##
## Godot (4.6) asks importers for endings of names, and takes `head.nii.gz` for one of `nii.gz`; its look at a project
## that it opens goes by what follows the last dot, so that such files come with the second look only. What imports a
## fresh project without a display has no second one.

const VolumeImporter := preload("import_plugin.gd")


func _enter_tree() -> void:
	var files := EditorInterface.get_resource_filesystem()
	# Otherwise the plugin is switched on in a project that is open, and the engine looks again by itself.
	if files.is_scanning():
		files.filesystem_changed.connect(_on_first_look, CONNECT_ONE_SHOT)


func _on_first_look() -> void:
	var files := EditorInterface.get_resource_filesystem()
	var missed := PackedStringArray()
	_look_into(files.get_filesystem(), missed)
	for path in missed:
		files.update_file(path)
	if not missed.is_empty():
		files.reimport_files(missed)


static func _look_into(folder: EditorFileSystemDirectory, missed: PackedStringArray) -> void:
	for i in folder.get_subdir_count():
		_look_into(folder.get_subdir(i), missed)
	for name in DirAccess.get_files_at(folder.get_path()):
		if VolumeImporter.COMPOUND_EXTENSIONS.any(func(end: String) -> bool: return name.to_lower().ends_with("." + end)) \
				and folder.find_file_index(name) < 0:
			missed.append(folder.get_path().path_join(name))
