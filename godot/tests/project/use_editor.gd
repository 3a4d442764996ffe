extends Node
## Uses the transfer-function editor in a running game with the mouse, then it and the camera with fingers, and tells
## what came of it.

var _editor := LumivoxTransferFunctionEditor.new()
var _function: LumivoxTransferFunction
var _changes := 0
var _edits: Array = []
var _told := {}


func _ready() -> void:
	_editor.size = Vector2(900.0, 400.0)
	add_child(_editor)
	var volume := LumivoxVolume.phantom("head", 48)
	_function = LumivoxTransferFunction.preset("ct-muscle", volume)
	_editor.volume = volume
	_editor.transfer_function = _function
	_function.changed.connect(func() -> void: _changes += 1)
	_editor.edit_finished.connect(func(before: Dictionary, after: Dictionary) -> void: _edits.append([before, after]))
	await get_tree().process_frame
	await get_tree().process_frame
	await _use_graph()
	_use_window()
	_use_colors()
	_use_files()
	print("TELL mouse %s" % JSON.stringify(_told))
	_told = {}
	await _touch_editor()
	await _touch_camera()
	print("TELL touch %s" % JSON.stringify(_told))
	get_tree().quit()


func _check(what: String, ok: bool) -> void:
	_told[what] = ok


func _press(at: Vector2, button := MOUSE_BUTTON_LEFT, double := false) -> void:
	_send_button(at, button, true, double)


func _release(at: Vector2, button := MOUSE_BUTTON_LEFT) -> void:
	_send_button(at, button, false, false)


func _send_button(at: Vector2, button: MouseButton, pressed: bool, double: bool) -> void:
	var event := InputEventMouseButton.new()
	event.position = at
	event.global_position = at
	event.button_index = button
	event.pressed = pressed
	event.double_click = double
	event.button_mask = MOUSE_BUTTON_MASK_LEFT if pressed else 0
	get_viewport().push_input(event, true)


func _move(at: Vector2, by: Vector2, mask := MOUSE_BUTTON_MASK_LEFT) -> void:
	var event := InputEventMouseMotion.new()
	event.position = at
	event.global_position = at
	event.relative = by
	event.button_mask = mask
	get_viewport().push_input(event, true)


func _drag(from: Vector2, by: Vector2) -> void:
	_press(from)
	_move(from + by, by)
	_release(from + by)


func _knot(index: int) -> Vector2:
	var graph: Control = _editor.get("_graph")
	return graph.get_global_transform() * (graph.call("_position_of", index) as Vector2)


func _strip(index: int) -> Control:
	return (_editor.get("_strips") as Array)[index] as Control


func _use_graph() -> void:
	var count := _function.opacity_knots.size()
	var from := _knot(2)
	_move(from, Vector2.ZERO, 0 as MouseButtonMask)
	_press(from)
	for i in range(1, 6):
		_move(from + i * Vector2(3.0, -4.0), Vector2(3.0, -4.0))
	_check("one change per motion", _changes == 5)
	_release(from + Vector2(15.0, -20.0))
	_check("one edit per drag", _edits.size() == 1)
	_check("a knot follows the mouse", _knot(2).distance_to(from + Vector2(15.0, -20.0)) < 0.5)
	var moved := _function.opacity_knots
	_editor.restore(_function, _edits[0][0] as Dictionary)
	_check("an edit is given back", _function.opacity_knots != moved)
	await get_tree().process_frame
	_check("the graph shows what was given back", _knot(2).distance_to(from) < 0.5)

	var free := from + Vector2(120.0, -60.0)
	_press(free, MOUSE_BUTTON_LEFT, true)
	_release(free)
	_check("a double click adds a knot", _function.opacity_knots.size() == count + 1 and _edits.size() == 2)
	var key := InputEventKey.new()
	key.keycode = KEY_DELETE
	key.pressed = true
	get_viewport().push_input(key)
	_check("Delete removes it", _function.opacity_knots.size() == count)
	_press(from, MOUSE_BUTTON_RIGHT)
	_release(from, MOUSE_BUTTON_RIGHT)
	_check("a right click removes a knot", _function.opacity_knots.size() == count - 1)


func _use_window() -> void:
	var strip := _strip(0)
	var points := _editor.get("_points") as RefCounted
	var extent: Vector2 = points.call("value_range")
	var middle := (extent.x + extent.y) / 2.0
	var at := strip.get_global_transform() * Vector2(strip.call("x_of", middle) as float, strip.size.y / 2.0)
	_drag(at, Vector2(40.0, 0.0))
	_check("the window shifts", _function.shift > 1.0 and is_equal_approx(_function.window_scale, 1.0))
	var level := (_editor.get("_middle") as SpinBox).value
	_check("the level is shown", absf(level - (middle + _function.shift)) < 0.1)

	var look := _function.get_opacity(400.0)
	var knot := _knot(3)
	_press(knot)
	_move(knot + Vector2(0.0, -1.0), Vector2(0.0, -1.0))
	_move(knot, Vector2(0.0, 1.0))
	_release(knot)
	var same := absf(_function.get_opacity(400.0) - look) < 1e-3
	_check("an edit of a shifted function keeps its look", _function.shift == 0.0 and same)


func _use_colors() -> void:
	var strip := _strip(2)
	var place := strip.get_global_transform()
	var before := _function.color_values[2]
	_drag(place * Vector2(strip.call("x_of", before) as float, strip.size.y * 0.7), Vector2(10.0, 0.0))
	_check("a colour moves", _function.color_values[2] > before)
	var count := _function.color_values.size()
	var free := place * Vector2(strip.call("x_of", 700.0) as float, strip.size.y * 0.3)
	_press(free, MOUSE_BUTTON_LEFT, true)
	_release(free)
	_check("a double click adds a colour", _function.color_values.size() == count + 1)

	var axis := _editor.get("_axis") as RefCounted
	var view: Vector2 = axis.get("view")
	_press(_knot(2), MOUSE_BUTTON_WHEEL_UP)
	_release(_knot(2), MOUSE_BUTTON_WHEEL_UP)
	var zoomed: Vector2 = axis.get("view")
	_check("the wheel zooms", zoomed.y - zoomed.x < view.y - view.x)


func _use_files() -> void:
	var path := OS.get_user_data_dir().path_join("edited.json")
	_check("it is saved", _function.save_file(path) == "")
	var back := LumivoxTransferFunction.load_file(path)
	_check("it is loaded again", back != null and back.opacity_knots.size() == _function.opacity_knots.size())
	_check("a folder that is not there is told", _function.save_file("/nonexistent/edited.json") != "")


## A finger goes down or up, as the system says it: the engine makes mouse events of it besides.
func _finger(at: Vector2, pressed: bool, index := 0, double := false) -> void:
	var event := InputEventScreenTouch.new()
	event.index = index
	event.position = get_viewport().get_screen_transform() * at
	event.pressed = pressed
	event.double_tap = double
	Input.parse_input_event(event)
	Input.flush_buffered_events()


func _slide(to: Vector2, by: Vector2, index := 0) -> void:
	var event := InputEventScreenDrag.new()
	event.index = index
	event.position = get_viewport().get_screen_transform() * to
	event.relative = get_viewport().get_screen_transform().basis_xform(by)
	Input.parse_input_event(event)
	Input.flush_buffered_events()


func _tap(at: Vector2, double := false) -> void:
	_finger(at, true, 0, double)
	_finger(at, false)


func _touch_editor() -> void:
	_editor.take(LumivoxTransferFunction.preset("ct-muscle", _editor.volume))
	await get_tree().process_frame
	# A finger is broad.
	var from := _knot(2)
	var aside := from + Vector2(4.0, 18.0)
	_finger(aside, true)
	_slide(aside + Vector2(6.0, -30.0), Vector2(6.0, -30.0))
	_finger(aside + Vector2(6.0, -30.0), false)
	_check("a finger beside a knot drags it", _knot(2).distance_to(from + Vector2(6.0, -30.0)) < 0.5)
	var count := _function.opacity_knots.size()
	var remove: Button = _editor.get("_remove")
	_check("a knot that was touched can be removed", not remove.disabled)
	_tap(remove.get_global_rect().get_center())
	_check("and is, by a button", _function.opacity_knots.size() == count - 1)
	_check("once", remove.disabled)
	var graph: Control = _editor.get("_graph")
	_tap(graph.global_position + graph.size * Vector2(0.9, 0.15), true)
	_check("a double tap adds a knot", _function.opacity_knots.size() == count)

	var strip := _strip(2)
	var colors := _function.color_values.size()
	var at := Vector2(strip.call("x_of", _function.color_values[1]) as float, strip.size.y * 0.7)
	_tap(strip.get_global_transform() * at)
	await get_tree().process_frame
	var popup: PopupPanel = strip.get("_popup")
	_check("a tap opens a colour", popup != null and popup.visible)
	(strip.get("_remove_button") as Button).pressed.emit()
	_check("which can be removed", _function.color_values.size() == colors - 1 and not popup.visible)
	await get_tree().process_frame


func _touch_camera() -> void:
	_editor.hide()
	var cover := Panel.new()
	cover.position = Vector2(0.0, 0.0)
	cover.size = Vector2(100.0, 100.0)
	add_child(cover)
	var camera := LumivoxOrbitCamera.new()
	add_child(camera)
	camera.make_current()
	await get_tree().process_frame
	var at := Vector2(500.0, 300.0)
	_finger(at, true)
	_slide(at + Vector2(50.0, 20.0), Vector2(50.0, 20.0))
	var turned := camera.azimuth
	_check("a finger turns once", is_equal_approx(turned, -50.0 * camera.turn_speed) and camera.pivot == Vector3.ZERO)
	at += Vector2(50.0, 20.0)
	var other := at + Vector2(100.0, 0.0)
	_finger(other, true, 1)
	_slide(other + Vector2(100.0, 0.0), Vector2(100.0, 0.0), 1)
	_check("two fingers zoom", is_equal_approx(camera.distance, 0.5) and camera.azimuth == turned)
	var before := camera.pivot
	_slide(at + Vector2(0.0, 40.0), Vector2(0.0, 40.0))
	_slide(other + Vector2(100.0, 40.0), Vector2(0.0, 40.0), 1)
	_check("and pan", camera.pivot.y > before.y and absf(camera.distance - 0.5) < 0.01 and camera.azimuth == turned)
	# One is lifted over a panel.
	_slide(Vector2(50.0, 50.0), Vector2.ZERO, 1)
	_finger(Vector2(50.0, 50.0), false, 1)
	turned = camera.azimuth
	_slide(at + Vector2(10.0, 40.0), Vector2(10.0, 0.0))
	_check("the finger that is left turns", not is_equal_approx(camera.azimuth, turned))
	_finger(at, false)
	turned = camera.azimuth
	_finger(Vector2(50.0, 50.0), true)
	_slide(Vector2(200.0, 50.0), Vector2(150.0, 0.0))
	_finger(Vector2(200.0, 50.0), false)
	_check("a finger from a panel does not", camera.azimuth == turned)
	_press(at)
	_move(at + Vector2(10.0, 0.0), Vector2(10.0, 0.0))
	_release(at)
	_check("a mouse still turns", camera.azimuth != turned)
