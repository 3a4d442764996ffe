@tool
extends "res://tests/editor/hands.gd"
## Looks at what the addon puts into the editor to be seen and pressed: icons, handles, galleries, where new nodes go, and views
## that are saved.

## The layer of what gizmos draw in the editor's viewports.
const GIZMO_LAYER := 26
## Pixels of the picture in which handles are looked at, along a side.
const PICTURE := 400
const FIELD_OF_VIEW := 40.0


## Of each node and resource of the addon, native or script, whether its icon is there.
func _icons() -> Dictionary:
	var listed := ConfigFile.new()
	listed.load("res://addons/lumivox/lumivox.gdextension")
	var told := {}
	for name in ClassDB.get_class_list():
		if not name.begins_with("Lumivox"):
			continue
		if ClassDB.is_parent_class(name, &"Node") or ClassDB.is_parent_class(name, &"Resource"):
			told[name] = _is_picture("res://addons/lumivox/".path_join(listed.get_value("icons", name, "none") as String))
	for script: Dictionary in ProjectSettings.get_global_class_list():
		var is_shown := ClassDB.is_parent_class(script.base, &"Node") or ClassDB.is_parent_class(script.base, &"Resource")
		if is_shown and (script.path as String).begins_with("res://addons/lumivox/"):
			told[script.class] = _is_picture(script.icon as String)
	return told


func _is_picture(path: String) -> bool:
	return ResourceLoader.exists(path) and load(path) is Texture2D


## How much of the node's box its handles cover where that is small on the screen and where it is large, and what a drag does to
## the box where it is small.
func _look_at_handles() -> Dictionary:
	_select(_node)
	await _seconds(0.3)
	var gizmo := _gizmo()
	var viewport := _watch_gizmos()
	var camera := viewport.get_camera_3d()
	var told := {}
	for diagonal: float in [30.0, 100.0, 300.0]:
		_place(camera, diagonal)
		told[str(int(diagonal))] = await _covered(viewport, camera)
	_place(camera, 30.0)
	var before := _node.clip_max
	gizmo.get_plugin().call("_set_handle", gizmo, 1, false, camera, Vector2(PICTURE, PICTURE) / 2.0)
	told.moved = _node.clip_max != before
	_node.clip_max = before
	viewport.queue_free()
	return told


## The addon's own of the node.
func _gizmo() -> EditorNode3DGizmo:
	for one in _node.get_gizmos():
		var own := one as EditorNode3DGizmo
		if own != null and own.get_plugin() != null and own.get_plugin().get_script() != null:
			return own
	return null


## A picture of gizmos alone.
func _watch_gizmos() -> SubViewport:
	var viewport := SubViewport.new()
	viewport.size = Vector2i(PICTURE, PICTURE)
	viewport.render_target_update_mode = SubViewport.UPDATE_ALWAYS
	viewport.world_3d = EditorInterface.get_edited_scene_root().get_world_3d()
	var camera := Camera3D.new()
	camera.fov = FIELD_OF_VIEW
	camera.near = 0.001
	camera.cull_mask = 1 << GIZMO_LAYER
	camera.environment = Environment.new()
	camera.environment.background_mode = Environment.BG_COLOR
	camera.environment.background_color = Color.BLACK
	viewport.add_child(camera)
	add_child(viewport)
	return viewport


## Puts a camera where the diagonal of the node's box takes up so many pixels.
func _place(camera: Camera3D, diagonal: float) -> void:
	var box := _node.get_local_box()
	var slope := tan(deg_to_rad(FIELD_OF_VIEW) / 2.0)
	var distance := box.size.length() * PICTURE / (2.0 * slope * diagonal)
	var center := _node.global_transform * box.get_center()
	camera.look_at_from_position(center + Vector3(0.5, 0.6, 0.7).normalized() * distance, center)


## Pixels of the box in a picture, and those that handles cover: where there is something with the node selected, and nothing
## without; lines are there both times.
func _covered(viewport: SubViewport, camera: Camera3D) -> Dictionary:
	var with := await _picture_of(viewport)
	EditorInterface.get_selection().clear()
	await _seconds(0.3)
	var without := await _picture_of(viewport)
	_select(_node)
	await _seconds(0.3)
	var place := _node.global_transform * _node.get_clip_transform()
	var corners := PackedVector2Array()
	for i in 8:
		corners.append(camera.unproject_position(place * Vector3(i & 1, (i >> 1) & 1, (i >> 2) & 1)))
	var hull := Geometry2D.convex_hull(corners)
	var box := 0
	var handles := 0
	for y in PICTURE:
		for x in PICTURE:
			if not Geometry2D.is_point_in_polygon(Vector2(x, y) + Vector2.ONE / 2.0, hull):
				continue
			box += 1
			if with.get_pixel(x, y).get_luminance() > 0.1 and without.get_pixel(x, y).get_luminance() < 0.02:
				handles += 1
	return {"box": box, "handles": handles}


func _picture_of(viewport: SubViewport) -> Image:
	for frame in 3:
		EditorInterface.get_base_control().queue_redraw()
		await RenderingServer.frame_post_draw
	return viewport.get_texture().get_image()


## Opens the gallery of presets by buttons in the corners of the window and in the inspector, and chooses one there.
func _open_galleries() -> Dictionary:
	var dock := _find_script("res://addons/lumivox/editor/transfer_function_dock.gd")
	var gallery := (dock.get("_editor") as Object).get("_gallery") as PopupPanel
	var room := Rect2(DisplayServer.screen_get_usable_rect(get_window().current_screen))
	var button := Vector2(80.0, 24.0)
	var told := {"corners": [], "listed": false, "chosen": false, "undone": false}
	for corner: Vector2 in [Vector2.ZERO, Vector2.RIGHT, Vector2.DOWN, Vector2.ONE]:
		gallery.call("open_at", Rect2(room.position + (room.size - button) * corner, button))
		told.corners.append(await _is_on_screen(gallery))
		gallery.hide()
	told.sizes = [gallery.size, room]
	_select(_node)
	await _seconds(0.5)
	var property := _find_script("res://addons/lumivox/editor/preset_property.gd")
	if property == null:
		return told
	var of_inspector := property.get("_gallery") as PopupPanel
	(property.get("_button") as Button).pressed.emit()
	await _seconds(0.3)
	told.inspector = of_inspector.visible and await _is_on_screen(of_inspector)
	await RenderingServer.frame_post_draw
	of_inspector.get_texture().get_image().save_png(_path("editor_presets.png"))
	told.listed = Array((of_inspector.get("_buttons") as Dictionary).keys()) == Array(LumivoxVolume3D.preset_names())
	var before := [_node.preset, _node.density, _node.transfer_function]
	var now := func() -> Array: return [_node.preset, _node.density, _node.transfer_function]
	((of_inspector.get("_buttons") as Dictionary)["ct-bone"] as Button).pressed.emit()
	await _seconds(0.3)
	# The inspector may be another since.
	told.chosen = _node.preset == "ct-bone" and not (is_instance_valid(of_inspector) and of_inspector.visible)
	_history().undo()
	told.undone = now.call() == before
	return told


func _is_on_screen(popup: Window) -> bool:
	await _seconds(0.2)
	var room := DisplayServer.screen_get_usable_rect(popup.current_screen)
	return room.encloses(Rect2i(popup.position, popup.size))


## New shapes below a volume of which a part is kept: how far, in metres, each is from what is kept.
func _fit_clips() -> Dictionary:
	var before := [_node.clip_min, _node.clip_max]
	_node.clip_min = Vector3(0.1, 0.0, 0.3)
	_node.clip_max = Vector3(0.5, 0.8, 1.0)
	var place := _node.get_clip_transform()
	var low := place * _node.clip_min
	var high := place * _node.clip_max
	var told := {}
	for shape: int in [LumivoxClip3D.SHAPE_BOX, LumivoxClip3D.SHAPE_SPHERE]:
		var clip := LumivoxClip3D.new()
		_node.add_child(clip)
		clip.shape = shape
		var at := clip.transform
		if shape == LumivoxClip3D.SHAPE_BOX:
			told.box = (at * (Vector3.ONE * -0.5)).distance_to(low) + (at * (Vector3.ONE * 0.5)).distance_to(high)
		else:
			var size := (high - low).abs()
			told.sphere = at.origin.distance_to((low + high) / 2.0) + absf(at.basis.get_scale().x - size[size.max_axis_index()])
		clip.free()
	var plane := LumivoxClip3D.new()
	_node.add_child(plane)
	told.fitted = plane.fit_to_volume()
	told.plane = plane.position.distance_to((low + high) / 2.0)
	plane.free()
	_node.clip_min = before[0]
	_node.clip_max = before[1]
	return told


## Opens an array with the dialog, and says of it what it does not say; then a series.
func _open_array() -> Dictionary:
	var dialog := _find_script("res://addons/lumivox/editor/import_dialog.gd") as ConfirmationDialog
	var fields := dialog.get("_array") as Control
	var field := func(option: String) -> LineEdit: return (fields.get("_fields") as Dictionary)[option]
	var scanned := func() -> bool: return dialog.get("_step") != 1
	dialog.call("open_path", (_arguments["study"] as String).path_join("array.npy"))
	await _until(scanned)
	var told := {"asks": fields.is_visible_in_tree()}
	print("EXPECT an error of the spacing")
	field.call("spacing").text = "half"
	field.call("spacing").text_submitted.emit("half")
	await _until(scanned)
	told.refused = (dialog.get("_details") as RichTextLabel).get_parsed_text()
	field.call("spacing").text = "0.5,1,2"
	field.call("layout").text = "xyz"
	field.call("layout").text_submitted.emit("xyz")
	told.dims = await _import_as(dialog, "res://from_array.res")
	var spacing := (load("res://from_array.res") as LumivoxVolume).get_spacing_mm()
	told.spacing = [spacing.x, spacing.y, spacing.z]
	dialog.call("open_path", (_arguments["study"] as String).path_join("good/small"))
	await _until(scanned)
	told.asks_of_others = fields.is_visible_in_tree()
	told.cleared = (fields.call("options") as Dictionary).is_empty()
	dialog.hide()
	return told


## The view as a scene file: of a phantom, which has no file, and of an imported scan.
func _save_view() -> Dictionary:
	var saver := _find_script("res://addons/lumivox/editor/scene_saver.gd")
	var told := {}
	print("EXPECT an error of a scan that has no file")
	told.made = saver.call("save", _path("made.lumivox"))
	var problem := saver.get("_problem") as AcceptDialog
	told.shown = problem.visible
	problem.hide()
	var before := _node.volume
	_node.volume = load("res://scans/grid.nrrd")
	await _seconds(0.5)
	told.saved = saver.call("save", _path("view.lumivox"))
	told.file = _path("view.lumivox")
	_node.volume = before
	await _seconds(0.5)
	return told
