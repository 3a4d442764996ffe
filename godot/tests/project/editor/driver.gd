@tool
extends "res://tests/editor/controls.gd"
## Uses the addon as somebody at the editor does, and tells what happens in lines `TELL NAME JSON`.

const CLASSES: PackedStringArray = [
	"LumivoxVolume3D", "LumivoxVolume", "LumivoxTransferFunction", "LumivoxEffect", "LumivoxImporter", "Lumivox",
	"LumivoxLabels", "LumivoxClip3D",
]


func _enter_tree() -> void:
	var words := OS.get_cmdline_user_args()
	for i in range(0, words.size() - 1, 2):
		_arguments[words[i].trim_prefix("--")] = words[i + 1]
	# Also loaded when the project is imported.
	if _arguments.has("cases"):
		_run.call_deferred()


func _run() -> void:
	while EditorInterface.get_resource_filesystem().is_scanning():
		await get_tree().process_frame
	await _seconds(1.0)
	# Asking for the broken file complains once more.
	_tell("scans", _scans())
	_tell("listed", _listed())
	_case = JSON.parse_string(FileAccess.get_file_as_string(_arguments["cases"]))[0]
	await _open_scene()
	# The editor's own viewport has many pixels, and nobody compares them.
	_effect().resolution_scale = 0.3
	_tell("idle", await _watch_idle_editor())
	await _save_picture("edited")
	_tell("undo", await _edit_and_undo())
	await _save_picture("undone")
	# Of what follows nobody compares the volume's pixels, and each step has the editor's viewport trace them all again.
	_effect().resolution_scale = 0.2
	_tell("inspector", await _inspect())
	_tell("dock", await _use_dock())
	await _screenshot("dock")
	_tell("raised", await _raise_dock())
	_tell("several", await _edit_several())
	_tell("icons", _icons())
	_tell("galleries", await _open_galleries())
	_tell("gizmo", await _drag_handle())
	_tell("handles", await _look_at_handles())
	_tell("fits", _fit_clips())
	_tell("clip", await _add_clip())
	_tell("parts", await _find_parts())
	_tell("dialog", await _use_dialog())
	_tell("menu", await _use_menu())
	_tell("arrays", await _open_array())
	_tell("empty", await _begin_with_nothing())
	_tell("view", await _save_view())
	_tell("four", await _four_views())
	await _screenshot("four")
	_tell("help", await _read_help())
	await _screenshot("help")
	_tell("plugin", await _restart_plugin())
	# The project file was changed, and the editor looks for more.
	await _seconds(4.0)
	get_tree().quit()


## What the import plugins made of the files under `res://scans`.
func _scans() -> Dictionary:
	var found := {}
	var folders: Array[String] = ["res://scans"]
	while not folders.is_empty():
		var folder: String = folders.pop_back()
		for name in DirAccess.get_directories_at(folder):
			folders.append(folder.path_join(name))
		for name in DirAccess.get_files_at(folder):
			var path := folder.path_join(name)
			if path.get_extension() == "import":
				continue
			var known := ResourceLoader.exists(path) and FileAccess.file_exists(path + ".import")
			var volume := load(path) as LumivoxVolume if known else null
			if volume == null:
				found[path.trim_prefix("res://scans/")] = null
				continue
			var dims := volume.get_dimensions()
			var spacing := volume.get_spacing_mm()
			var values := volume.get_value_range()
			found[path.trim_prefix("res://scans/")] = {
				"dims": [dims.x, dims.y, dims.z], "spacing": [spacing.x, spacing.y, spacing.z],
				"range": [values.x, values.y], "part_of": volume.get_meta(&"lumivox_series", ""),
				"name": volume.resource_name, "unit": volume.get_unit(),
			}
	return found


## What Godot takes the files for whose endings may be anything's, and which of them are still imported.
func _listed() -> Dictionary:
	var told := {"settings": [], "types": {}}
	for file: String in ["archive.zip", "data.zip", "former.zip", "level.gz", "texture.raw"]:
		var path := "res://scans/" + file
		told.types[file] = EditorInterface.get_resource_filesystem().get_file_type(path)
		if FileAccess.file_exists(path + ".import"):
			told.settings.append(path + ".import")
	return told


func _editor_status() -> Dictionary:
	return Lumivox.get_status(EditorInterface.get_editor_viewport_3d(0))


## Nobody touches anything: the viewport must converge all the same, and then the editor must rest.
func _watch_idle_editor() -> Dictionary:
	var before := _editor_status()
	# A timer that ends draws nothing.
	var converged := await _until(func() -> bool: return _editor_status().get("converged", false))
	await _seconds(1.0)
	var drawn := Engine.get_frames_drawn()
	await _seconds(2.0)
	return {
		"before": before, "after": _editor_status(), "converged": converged,
		"drawn_at_rest": Engine.get_frames_drawn() - drawn,
		"low_processor_mode": OS.low_processor_usage_mode,
	}


## An edit restarts the image, undo brings the old value back.
func _edit_and_undo() -> Dictionary:
	var told := {"before": _node.density}
	get_undo_redo().create_action("Make denser", UndoRedo.MERGE_DISABLE, _node)
	get_undo_redo().add_do_property(_node, &"density", _node.density * 4.0)
	get_undo_redo().add_undo_property(_node, &"density", _node.density)
	get_undo_redo().commit_action()
	told.after = _node.density
	told.restarted = await _until(func() -> bool: return not _editor_status().get("converged", true))
	told.converged = await _until(func() -> bool: return _editor_status().get("converged", false))
	_history().undo()
	told.undone = _node.density
	_history().redo()
	told.redone = _node.density
	_history().undo()
	return told


## What the inspector shows of a volume, and an edit as the inspector makes it.
func _inspect() -> Dictionary:
	EditorInterface.edit_node(_node)
	await _seconds(0.5)
	var properties := {}
	for property: EditorProperty in _find_all(
			EditorInterface.get_inspector(), func(node: Node) -> bool: return node is EditorProperty):
		if property.get_edited_object() == _node:
			properties[property.get_edited_property()] = property
	var groups := []
	for property in _node.get_property_list():
		if (property.usage as int) & PROPERTY_USAGE_GROUP != 0:
			groups.append(property.name)
	var before := _node.density
	var told := {"properties": properties.keys(), "groups": groups, "clipped": _clipped_names(properties)}
	EditorInterface.edit_resource(LumivoxEffect.new())
	await _seconds(0.5)
	var effects := {}
	for property: EditorProperty in _find_all(
			EditorInterface.get_inspector(), func(node: Node) -> bool: return node is EditorProperty):
		effects[property.get_edited_property()] = property
	told.clipped_of_effect = _clipped_names(effects)
	EditorInterface.edit_node(_node)
	await _seconds(0.5)
	for property: EditorProperty in _find_all(
			EditorInterface.get_inspector(), func(node: Node) -> bool: return node is EditorProperty):
		if property.get_edited_object() == _node:
			properties[property.get_edited_property()] = property
	if properties.has(&"density"):
		(properties[&"density"] as EditorProperty).emit_changed(&"density", 0.25)
		await get_tree().process_frame
		told.edited = _node.density
		told.action = _history().get_current_action_name()
		_history().undo()
		told.undone = is_equal_approx(_node.density, before)
	return told


func _use_dock() -> Dictionary:
	var dock := _find_script("res://addons/lumivox/editor/transfer_function_dock.gd") as Control
	make_bottom_panel_item_visible(dock)
	_focus()
	await _seconds(1.0)
	await _until(func() -> bool: return _editor_status().get("converged", false))
	var editor := dock.get("_editor") as LumivoxTransferFunctionEditor
	var told := {
		"visible": dock.is_visible_in_tree() and editor.is_visible_in_tree(),
		"follows": editor.transfer_function == _node.transfer_function and editor.volume == _node.volume,
		"knot": _node.transfer_function.opacity_knots[1].y,
	}
	editor.call("_begin")
	(editor.get("_points") as RefCounted).call("move_knot", 1, Vector2(_node.transfer_function.opacity_knots[1].x, 0.75))
	editor.call("_write")
	editor.call("_end")
	told.moved = _node.transfer_function.opacity_knots[1].y
	told.action = _history().get_current_action_name()
	_history().undo()
	told.undone = _node.transfer_function.opacity_knots[1].y
	var look := _node.density
	editor.preset_chosen.emit("ct-bone")
	told.preset = _node.preset
	told.preset_action = _history().get_current_action_name()
	_history().undo()
	told.preset_undone = is_equal_approx(_node.density, look) and _node.preset != "ct-bone"
	return told


## What raises the dock, and what it shows of a volume without a function of its own.
func _raise_dock() -> Dictionary:
	var dock := _find_script("res://addons/lumivox/editor/transfer_function_dock.gd") as Control
	var editor := dock.get("_editor") as LumivoxTransferFunctionEditor
	var told := {"suited": {}, "clipped": []}
	hide_bottom_panel()
	await _seconds(0.3)
	told.hidden = not dock.is_visible_in_tree()
	told.by_node = await _is_raised_by(dock, func() -> void: _select(_node))
	told.by_function = await _is_raised_by(dock, func() -> void: EditorInterface.edit_resource(_node.transfer_function))
	told.edits_it = editor.transfer_function == _node.transfer_function and editor.volume == _node.volume
	var alone := LumivoxTransferFunction.preset("ct-bone", null)
	told.by_script = await _is_raised_by(dock, func() -> void: EditorInterface.edit_resource(alone))
	told.edits_that = editor.transfer_function == alone and editor.is_visible_in_tree()
	var bare := LumivoxVolume3D.new()
	bare.name = "Bare"
	bare.volume = _node.volume
	var root := EditorInterface.get_edited_scene_root()
	root.add_child(bare)
	bare.owner = root
	told.by_empty = await _is_raised_by(dock, func() -> void: _select(bare))
	await _screenshot("suited")
	told.clipped = _clipped_labels(dock)
	var notice := dock.get("_notice") as Label
	var preset := LumivoxTransferFunction.preset("ct-muscle", bare.volume)
	var suited: Dictionary = told.suited
	suited.shown = editor.is_visible_in_tree() and bare.transfer_function == null
	suited.as_preset = editor.transfer_function != null \
			and editor.transfer_function.opacity_knots == preset.opacity_knots
	suited.notice = notice.text
	editor.call("_begin")
	(editor.get("_points") as RefCounted).call("move_knot", 1, Vector2(preset.opacity_knots[1].x, 0.75))
	editor.call("_write")
	suited.adopted = bare.transfer_function != null and bare.transfer_function == editor.transfer_function
	editor.call("_end")
	var has_moved := func() -> bool:
		return bare.transfer_function != null and is_equal_approx(bare.transfer_function.opacity_knots[1].y, 0.75)
	suited.moved = has_moved.call()
	_history().undo()
	suited.undone = bare.transfer_function == null
	await _seconds(0.3)
	suited.shown_again = editor.is_visible_in_tree() and editor.transfer_function.opacity_knots == preset.opacity_knots
	_history().redo()
	suited.redone = bare.transfer_function != null
	suited.redone_knot = has_moved.call()
	_history().undo()
	bare.preset = "ct-bone"
	await _seconds(0.3)
	suited.chosen = notice.text
	_select(_node)
	bare.free()
	await _seconds(0.3)
	return told


## Gives two selected volumes a preset, in the inspector and in the dock.
func _edit_several() -> Dictionary:
	var other := LumivoxVolume3D.new()
	other.name = "Other"
	other.volume = _node.volume
	other.density = 3.0
	other.position.x = 1.0
	var root := EditorInterface.get_edited_scene_root()
	root.add_child(other)
	other.owner = root
	var both: Array[LumivoxVolume3D] = [_node, other]
	EditorInterface.get_selection().clear()
	for node in both:
		EditorInterface.get_selection().add_node(node)
	await _seconds(0.5)
	await _screenshot("several")
	var told := {"inspector": {}, "dock": {}}
	var property := _find_script("res://addons/lumivox/editor/preset_property.gd")
	if property != null:
		var gallery := property.get("_gallery") as Object
		told.inspector = _apply_to(both, "ct-bone", func() -> void: gallery.emit_signal("chosen", "ct-bone"))
	var dock := _find_script("res://addons/lumivox/editor/transfer_function_dock.gd")
	var editor := dock.get("_editor") as LumivoxTransferFunctionEditor
	told.dock = _apply_to(both, "ct-skin", func() -> void: editor.preset_chosen.emit("ct-skin"))
	EditorInterface.get_selection().clear()
	EditorInterface.get_selection().add_node(_node)
	other.free()
	await _seconds(0.3)
	return told


## Imports the second phase of a study's best series with the dialog, and shows it what it cannot import.
func _use_dialog() -> Dictionary:
	var dialog := _find_script("res://addons/lumivox/editor/import_dialog.gd") as ConfirmationDialog
	var tree := dialog.get("_series") as Tree
	var details := dialog.get("_details") as RichTextLabel
	var scanned := func() -> bool: return dialog.get("_step") != 1
	dialog.call("open_path", (_arguments["study"] as String).path_join("good"))
	await _until(scanned)
	await get_tree().process_frame
	var told := {"rows": [], "first": details.get_parsed_text()}
	for item in tree.get_root().get_children():
		told.rows.append(range(tree.columns).map(func(column: int) -> String: return item.get_text(column)))
	var picture := dialog.get("_thumbnail") as TextureRect
	var pictured := func() -> bool: return picture.texture != null
	told.pictures = [await _picture_in(picture)]
	tree.get_root().get_child(1).select(0)
	await get_tree().process_frame
	told.second = details.get_parsed_text()
	told.pictures.append(await _picture_in(picture))
	# Chosen one after the other: the last is shown, and the first is not waited for.
	tree.get_root().get_child(0).select(0)
	told.waited = pictured.call()
	tree.get_root().get_child(1).select(0)
	told.pictures.append(await _picture_in(picture))
	# Closed before it is made, and opened again.
	tree.get_root().get_child(0).select(0)
	dialog.canceled.emit()
	dialog.hide()
	told.stopped = not pictured.call()
	dialog.call("open")
	told.pictures.append(await _picture_in(picture))
	told.proposed = [(dialog.get("_target") as LineEdit).text]
	tree.get_root().get_child(1).select(0)
	await _seconds(0.5)
	told.proposed.append((dialog.get("_target") as LineEdit).text)
	dialog.get_texture().get_image().save_png(_path("editor_dialog.png"))
	tree.get_root().get_child(0).select(0)
	await get_tree().process_frame
	(dialog.get("_phase") as SpinBox).value = 2.0
	(dialog.get("_target") as LineEdit).text = "res://opened.res"
	# Stopped, and started again.
	var described := details.get_parsed_text()
	dialog.get_ok_button().pressed.emit()
	dialog.call("open_path", (_arguments["study"] as String).path_join("good/small"))
	dialog.canceled.emit()
	await _until(func() -> bool: return dialog.get("_step") == 2)
	told.as_before = described != "" and details.get_parsed_text() == described
	dialog.get_ok_button().pressed.emit()
	# Another folder is dropped while this one is imported, and while it is saved.
	told.refused = []
	for step: int in [3, 4]:
		await _until(func() -> bool: return dialog.get("_step") == step)
		dialog.call("open_path", (_arguments["study"] as String).path_join("good/small"))
		told.refused.append([step, dialog.get("_step"), details.get_parsed_text()])
	await _until(func() -> bool: return not dialog.visible)
	var root := EditorInterface.get_edited_scene_root()
	var node := root.get_node_or_null("Opened") as LumivoxVolume3D
	told.added = node != null and node.owner == root and FileAccess.file_exists("res://opened.res")
	if node != null:
		var values := node.volume.get_value_range()
		told.range = [values.x, values.y]
		told.saved_as = node.volume.resource_path
	_history().undo()
	told.undone = not root.has_node("Opened")
	# A header whose data lie elsewhere, before and after that is allowed; the next one is trusted no more.
	var outside := dialog.get("_allow_outside") as CheckBox
	told.outside = [outside.visible]
	var header := (_arguments["study"] as String).path_join("outside/header/scan.mhd")
	dialog.call("open_path", header)
	await _until(scanned)
	told.outside.append_array([outside.is_visible_in_tree(), dialog.get("_step"), details.get_parsed_text()])
	outside.button_pressed = true
	await _until(scanned)
	told.outside.append(dialog.get("_step"))
	dialog.call("open_path", header)
	await _until(scanned)
	told.outside.append_array([outside.button_pressed, dialog.get("_step")])
	dialog.call("open_path", "/nowhere/at/all")
	told.nowhere = details.get_parsed_text()
	dialog.call("open_path", (_arguments["study"] as String).path_join("bad"))
	await _until(scanned)
	told.bad = details.get_parsed_text()
	told.bad_step = dialog.get("_step")
	await _seconds(0.5)
	dialog.get_texture().get_image().save_png(_path("editor_dialog_bad.png"))
	dialog.hide()
	return told


## Imports an archive by the menu of the FileSystem dock, and a raw file with a description.
func _use_menu() -> Dictionary:
	var told := {"offered": {}, "listed": _listed().types}
	for file: String in ["archive.zip", "ct", "grid.nrrd"]:
		told.offered[file] = await _open_menu("res://scans/".path_join(file)) >= 0
	var item := await _open_menu("res://scans/archive.zip")
	await _screenshot("menu")
	if item >= 0:
		_menu.id_pressed.emit(_menu.get_item_id(item))
	if _menu != null:
		_menu.hide()
	var dialog := _find_script("res://addons/lumivox/editor/import_dialog.gd") as ConfirmationDialog
	told.archive = await _import_as(dialog, "res://from_archive.res")
	var details := dialog.get("_details") as RichTextLabel
	var description := dialog.get("_raw") as LineEdit
	var scanned := func() -> bool: return dialog.get("_step") != 1
	dialog.call("open_path", "res://scans/texture.raw")
	await _until(scanned)
	told.undescribed = details.get_parsed_text()
	told.asks = description.is_visible_in_tree()
	await _seconds(0.5)
	dialog.get_texture().get_image().save_png(_path("editor_dialog_raw.png"))
	print("EXPECT an error of the description")
	description.text = "5x6"
	description.text_submitted.emit(description.text)
	await _until(scanned)
	told.misdescribed = details.get_parsed_text()
	description.text = "5x6x7:i16le:spacing=1,2,3"
	description.text_submitted.emit(description.text)
	told.raw = await _import_as(dialog, "res://from_raw.res")
	var values := (load("res://from_raw.res") as LumivoxVolume).get_value_range()
	told.raw_range = [values.x, values.y]
	told.dropped = ["archive.zip", "level.gz"].map(func(file: String) -> bool:
		return dialog.call("is_dicom_archive", "res://scans/" + file))
	return told


## A node as the scene dock adds it: what it warns of, and the inspector's ways to a scan.
func _begin_with_nothing() -> Dictionary:
	var node := LumivoxVolume3D.new()
	node.name = "New"
	var root := EditorInterface.get_edited_scene_root()
	root.add_child(node)
	node.owner = root
	EditorInterface.get_selection().clear()
	EditorInterface.get_selection().add_node(node)
	EditorInterface.edit_node(node)
	await _seconds(0.5)
	await _screenshot("empty")
	var lacks_scan := func() -> bool: return "There is no scan to show" in _warnings_of(node)
	var told := {"warned": await _until(lacks_scan), "gizmo": not node.get_gizmos().is_empty()}
	var press := func(text: String) -> void:
		for button in _find_all(EditorInterface.get_inspector(), func(one: Node) -> bool: return one is Button):
			if (button as Button).text == text:
				(button as Button).pressed.emit()
	press.call("Import a Scan...")
	var dialog := _find_script("res://addons/lumivox/editor/import_dialog.gd") as ConfirmationDialog
	told.offers = (dialog.get("_add_to_scene") as CheckBox).text
	dialog.call("open_path", (_arguments["study"] as String).path_join("good/small"))
	await _until(func() -> bool: return dialog.get("_step") != 1)
	(dialog.get("_target") as LineEdit).text = "res://given.res"
	dialog.get_ok_button().pressed.emit()
	await _until(func() -> bool: return not dialog.visible)
	told.given = node.volume != null and node.volume.get_dimensions() == Vector3i(12, 12, 12)
	told.content = await _until(func() -> bool: return not lacks_scan.call())
	_history().undo()
	told.undone = node.volume == null
	EditorInterface.edit_node(node)
	await _seconds(0.5)
	press.call("Try a Phantom")
	told.phantom = await _until(func() -> bool: return node.volume != null)
	told.saved = node.volume != null and node.volume.resource_path == "res://head_phantom.res" \
			and FileAccess.file_exists("res://head_phantom.res")
	EditorInterface.get_selection().clear()
	EditorInterface.get_selection().add_node(_node)
	EditorInterface.edit_node(_node)
	node.free()
	await _seconds(0.3)
	return told


## Drags a face of the clip box.
func _drag_handle() -> Dictionary:
	var gizmo := _gizmo()
	if gizmo == null:
		return {"found": false}
	var viewport := _watch_gizmos()
	var camera := viewport.get_camera_3d()
	_place(camera, 300.0)
	var place := _node.global_transform * _node.get_clip_transform()
	var before := _node.clip_max
	gizmo.get_plugin().call("_set_handle", gizmo, 1, false, camera, camera.unproject_position(place * Vector3(0.7, 0.5, 0.5)))
	var dragged := _node.clip_max.x
	gizmo.get_plugin().call("_commit_handle", gizmo, 1, false, before, false)
	await _screenshot("clipped")
	_history().undo()
	viewport.queue_free()
	return {"found": true, "dragged": dragged, "undone": _node.clip_max == before}


## A plane, a box and a sphere that cut the volume, one after the other: what the viewport draws of them.
func _add_clip() -> Dictionary:
	var clip := LumivoxClip3D.new()
	clip.name = "Clip"
	clip.rotation = Vector3(0.4, 0.0, -1.0)
	_node.add_child(clip)
	clip.owner = EditorInterface.get_edited_scene_root()
	EditorInterface.get_selection().clear()
	EditorInterface.get_selection().add_node(clip)
	await _seconds(0.5)
	var plugins := clip.get_gizmos().filter(func(one: Node3DGizmo) -> bool:
		return one is EditorNode3DGizmo and one.get_plugin().get_script() != null)
	var told := {"gizmos": plugins.size(), "lines": []}
	for shape in 3:
		clip.shape = shape
		clip.inverted = shape == 1
		clip.scale = Vector3.ONE if shape == 0 else Vector3(0.2, 0.16, 0.2)
		var lines: Dictionary = plugins[0].get_plugin().call("lines_of", clip) if not plugins.is_empty() else {}
		told.lines.append([lines.get("shape", []).size(), lines.get("kept", []).size()])
		await _screenshot("clip%d" % shape)
	_node.remove_child(clip)
	clip.free()
	EditorInterface.get_selection().clear()
	return told


## The inspector's button: cancelled, then pressed again, and undone.
func _find_parts() -> Dictionary:
	EditorInterface.get_selection().add_node(_node)
	EditorInterface.edit_node(_node)
	await _seconds(0.5)
	var told := {"before": _node.labels == null, "path": "", "file": false}
	var button := _parts_button()
	told.offered = button != null
	if button == null:
		return told
	button.pressed.emit()
	button.pressed.emit()
	told.cancelled = await _until(func() -> bool: return not button.has_meta(&"task")) and _node.labels == null
	button.pressed.emit()
	told.found = await _until(func() -> bool: return _node.labels != null)
	if told.found:
		told.path = _node.labels.resource_path
		told.file = FileAccess.file_exists(_node.labels.resource_path)
		told.names = Array(_node.labels.get_names())
		var shown := _node.transfer_function
		var clear := LumivoxTransferFunction.new()
		clear.opacity_knots = [Vector2(8000.0, 0.0), Vector2(9000.0, 1.0)]
		var warned := func() -> bool: return "'body' is painted, but the look hides it" in _warnings_of(_node)
		_node.labels.set_label("body", "painted", true)
		_node.transfer_function = clear
		told.painted = await _until(warned)
		_node.transfer_function = shown
		told.content = await _until(func() -> bool: return not warned.call())
		_node.labels.set_label("body", "painted", false)
	_history().undo()
	told.undone = _node.labels == null
	return told


func _parts_button() -> Button:
	var found := _find_all(EditorInterface.get_inspector(), func(node: Node) -> bool:
		return node is Button and (node as Button).text == "Find Parts")
	return null if found.is_empty() else found[0] as Button


func _four_views() -> Dictionary:
	_choose("4 Viewports")
	await _seconds(1.0)
	var told := []
	for i in 4:
		var viewport := EditorInterface.get_editor_viewport_3d(i)
		var converged := await _until(func() -> bool: return Lumivox.get_status(viewport).get("converged", false))
		told.append({"converged": converged, "status": Lumivox.get_status(viewport)})
	return {"views": told}


## What F1 shows of each class.
func _read_help() -> Dictionary:
	var told := {}
	for name in CLASSES:
		EditorInterface.set_main_screen_editor("Script")
		EditorInterface.get_script_editor().goto_help("class_name:" + name)
		await _seconds(0.4)
		var shown := _find_all(EditorInterface.get_script_editor(), func(node: Node) -> bool:
			return node.get_class() == "EditorHelp" and node.name == name)
		if shown.is_empty():
			told[name] = ""
			continue
		var text := _find_all(shown[0], func(node: Node) -> bool: return node is RichTextLabel)[0] as RichTextLabel
		await _until(func() -> bool: return text.is_finished())
		told[name] = text.get_parsed_text()
	return told


func _restart_plugin() -> Dictionary:
	EditorInterface.set_plugin_enabled("lumivox", false)
	await _seconds(0.3)
	var gone := _find_script("res://addons/lumivox/editor/transfer_function_dock.gd") == null
	var is_off := func() -> bool: return "plugin is off" in _warnings_of(_node)
	var warned := await _until(is_off)
	EditorInterface.set_plugin_enabled("lumivox", true)
	await _seconds(0.3)
	return {
		"gone": gone, "back": _find_script("res://addons/lumivox/editor/transfer_function_dock.gd") != null,
		"warned": warned, "content": await _until(func() -> bool: return not is_off.call()),
	}
