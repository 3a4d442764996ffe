@tool
extends EditorPlugin
## Hands and eyes at the editor: opens, selects, chooses, waits and looks. What they are used for is in `driver.gd`.

const PATIENCE_MS := 240_000

var _arguments := {}
var _case := {}
var _node: LumivoxVolume3D
## What the FileSystem dock opened.
var _menu: PopupMenu


func _tell(name: String, what: Variant) -> void:
	print("TELL %s %s" % [name, JSON.stringify(what, "", true, true)])


func _seconds(duration: float) -> void:
	await get_tree().create_timer(duration).timeout


func _path(name: String) -> String:
	return (_arguments["out"] as String).path_join(name)


func _screenshot(name: String) -> void:
	await _seconds(0.5)
	# An editor at rest draws nothing.
	EditorInterface.get_base_control().queue_redraw()
	await RenderingServer.frame_post_draw
	get_window().get_texture().get_image().save_png(_path("editor_%s.png" % name))


func _until(condition: Callable) -> bool:
	var begin := Time.get_ticks_msec()
	while Time.get_ticks_msec() - begin < PATIENCE_MS:
		if condition.call():
			return true
		await get_tree().process_frame
	return false


## Saves the case as a scene, and opens that.
func _open_scene() -> void:
	var root := LumivoxCase.build(_case)
	root.get_node("Camera").free()
	for node in root.get_children():
		node.owner = root
	var packed := PackedScene.new()
	packed.pack(root)
	ResourceSaver.save(packed, "res://edited.scn")
	root.free()
	EditorInterface.open_scene_from_path("res://edited.scn")
	EditorInterface.set_main_screen_editor("3D")
	await _seconds(0.5)
	for child in EditorInterface.get_edited_scene_root().get_children():
		if child is LumivoxVolume3D:
			_node = child
			break


func _effect() -> LumivoxEffect:
	var world: WorldEnvironment = EditorInterface.get_edited_scene_root().get_node("World")
	return world.compositor.compositor_effects[0]


## What a camera sees of the scene that is edited.
func _save_picture(name: String) -> void:
	# At full size, as in a game.
	var scale := _effect().resolution_scale
	_effect().resolution_scale = 1.0
	var viewport := SubViewport.new()
	viewport.size = Vector2i(int(_case.size[0]), int(_case.size[1]))
	viewport.render_target_update_mode = SubViewport.UPDATE_ALWAYS
	viewport.world_3d = EditorInterface.get_edited_scene_root().get_world_3d()
	var camera := LumivoxCase.camera(_case)
	viewport.add_child(camera)
	add_child(viewport)
	await RenderingServer.frame_post_draw
	await RenderingServer.frame_post_draw
	var converged := await _until(func() -> bool: return Lumivox.is_converged(viewport))
	for frame in 2:
		EditorInterface.get_base_control().queue_redraw()
		await RenderingServer.frame_post_draw
	if not converged:
		push_error("%s does not converge: %s" % [name, Lumivox.get_status(viewport)])
	LumivoxCase.save(viewport, _path(name))
	viewport.queue_free()
	_effect().resolution_scale = scale
	await get_tree().process_frame


func _history() -> UndoRedo:
	return get_undo_redo().get_history_undo_redo(get_undo_redo().get_object_history_id(_node))


func _find_all(node: Node, matches: Callable, found: Array[Node] = []) -> Array[Node]:
	if matches.call(node):
		found.append(node)
	for child in node.get_children(true):
		_find_all(child, matches, found)
	return found


func _find_script(path: String) -> Node:
	var found := _find_all(EditorInterface.get_base_control(), func(node: Node) -> bool:
		return node.get_script() != null and (node.get_script() as Script).resource_path == path)
	return found[0] if not found.is_empty() else null


## The names of the addon's properties that have less room than they need, with the arrow that reverts them.
func _clipped_names(properties: Dictionary) -> Array:
	var clipped := []
	var theme := EditorInterface.get_editor_theme()
	var width := EditorInterface.get_inspector().size.x
	for name: StringName in properties:
		var property := properties[name] as EditorProperty
		if not ClassDB.class_has_method(property.get_edited_object().get_class(), "set_" + name, true):
			continue
		var text := theme.default_font.get_string_size(
				property.label, HORIZONTAL_ALIGNMENT_LEFT, -1.0, theme.default_font_size).x
		if text + 28.0 > width * property.name_split_ratio:
			clipped.append("%s of %s: %s in %s" % [property.label, width, text, property.name_split_ratio])
	return clipped


## Brings the selection into view, in every viewport.
func _focus() -> void:
	_choose("Focus Selection")


## Chooses what is called so in all menus of the 3D editor.
func _choose(text: String) -> void:
	for found in _find_all(EditorInterface.get_editor_main_screen(), func(node: Node) -> bool: return node is PopupMenu):
		var menu := found as PopupMenu
		for i in menu.item_count:
			if menu.get_item_text(i) == text:
				menu.id_pressed.emit(menu.get_item_id(i))


func _select(node: Node) -> void:
	EditorInterface.get_selection().clear()
	EditorInterface.get_selection().add_node(node)
	EditorInterface.edit_node(node)


func _is_raised_by(dock: Control, act: Callable) -> bool:
	hide_bottom_panel()
	await _seconds(0.3)
	act.call()
	await _seconds(0.5)
	return dock.is_visible_in_tree()


## The texts in a control that have less room than they need.
func _clipped_labels(control: Control) -> Array:
	var clipped := []
	for found in _find_all(control, func(node: Node) -> bool: return node is Label and (node as Label).is_visible_in_tree()):
		var label := found as Label
		var font := label.get_theme_font(&"font")
		var needed := font.get_string_size(
				label.text, HORIZONTAL_ALIGNMENT_LEFT, -1.0, label.get_theme_font_size(&"font_size")).x
		if label.autowrap_mode == TextServer.AUTOWRAP_OFF and needed > label.size.x + 1.0:
			clipped.append(label.text)
	return clipped


func _apply_to(nodes: Array[LumivoxVolume3D], preset: String, choose: Callable) -> Dictionary:
	var inspector := load("res://addons/lumivox/editor/volume_inspector.gd") as GDScript
	var state := func() -> Array: return nodes.map(func(node: LumivoxVolume3D) -> Dictionary: return inspector.call("stored", node))
	var before: Array = state.call()
	choose.call()
	var after: Array = state.call()
	var told := {"action": _history().get_current_action_name()}
	told.applied = nodes.all(func(node: LumivoxVolume3D) -> bool: return node.preset == preset and node.surface_strength > 0.0)
	_history().undo()
	told.undone = state.call() == before
	_history().redo()
	told.redone = state.call() == after
	_history().undo()
	told.undone_again = state.call() == before
	return told


## Opens the menu of a file or folder in the FileSystem dock. Returns which of its items imports it, or -1.
func _open_menu(path: String) -> int:
	var dock := EditorInterface.get_file_system_dock()
	var tree := _find_all(dock, func(node: Node) -> bool: return node is Tree)[0] as Tree
	# A look for changed files that is under way sets the tree anew.
	await _until(func() -> bool:
		if EditorInterface.get_resource_filesystem().is_scanning():
			return false
		dock.navigate_to_path(path)
		return tree.get_selected() != null and tree.get_selected().get_text(0) == path.get_file())
	await _seconds(0.3)
	tree.item_mouse_selected.emit(Vector2.ZERO, MOUSE_BUTTON_RIGHT)
	await _seconds(0.3)
	_menu = null
	for found in _find_all(dock, func(node: Node) -> bool: return node is PopupMenu and (node as PopupMenu).visible):
		_menu = found as PopupMenu
		for i in _menu.item_count:
			if _menu.get_item_text(i) == "Import as Lumivox Volume...":
				return i
	if _menu != null:
		_menu.hide()
	return -1


## Imports what the dialog looks at. Returns how many voxels it has.
func _import_as(dialog: ConfirmationDialog, path: String) -> Array:
	await _until(func() -> bool: return dialog.get("_step") == 2)
	(dialog.get("_add_to_scene") as CheckBox).button_pressed = false
	(dialog.get("_target") as LineEdit).text = path
	dialog.get_ok_button().pressed.emit()
	await _until(func() -> bool: return not dialog.visible)
	(dialog.get("_add_to_scene") as CheckBox).button_pressed = true
	var volume := load(path) as LumivoxVolume if FileAccess.file_exists(path) else null
	if volume == null:
		return []
	var dims := volume.get_dimensions()
	return [dims.x, dims.y, dims.z]


## Sums up the picture that a dialog shows, once it is there.
func _picture_in(rect: TextureRect) -> Array:
	if not await _until(func() -> bool: return rect.texture != null):
		return []
	var image := rect.texture.get_image()
	return [image.get_width(), image.get_height(), hash(image.get_data())]


## What the scene dock warns of at a node.
func _warnings_of(node: Node) -> String:
	var text := ""
	for found in _find_all(EditorInterface.get_base_control(), func(one: Node) -> bool:
			return one is Tree and one.get_parent().get_class() == "SceneTreeEditor"):
		var item := (found as Tree).get_root()
		while item != null:
			if item.get_text(0) == node.name:
				for i in item.get_button_count(0):
					text += item.get_button_tooltip_text(0, i)
			item = item.get_next_in_tree()
	return text
