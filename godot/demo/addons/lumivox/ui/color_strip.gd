@tool
extends "value_strip.gd"
## The colours of a transfer function: a gradient with stops under it.
##
## A click opens a stop's colour, a drag moves it, a double-click adds one, a right click removes it.

var _pressed := -1
var _dragged := false
var _picked := -1
var _popup: PopupPanel
var _picker: ColorPicker
var _remove_button: Button


func _init() -> void:
	super()
	custom_minimum_size = Vector2(0.0, 38.0)


func _enter_tree() -> void:
	custom_minimum_size.y = scaled(38.0)


func handle_count() -> int:
	return points.color_values.size()


func handle_distance(stop: int, at: Vector2) -> float:
	return absf(x_of(points.shown(points.color_values[stop])) - at.x)


func remove_point(stop: int) -> bool:
	return points.remove_stop(stop)


func drop() -> void:
	_pressed = -1
	_dragged = false
	super()
	# It shows a stop that is no more.
	_picked = -1
	if _popup != null:
		_popup.hide()


func _on_button(button: InputEventMouseButton) -> void:
	var stop := handle_at(button)
	if button.button_index == MOUSE_BUTTON_LEFT:
		if button.pressed:
			if stop < 0 and button.double_click:
				_add(value_at(button.position.x))
			_pressed = stop
			_dragged = false
		else:
			if _dragged:
				end_edit()
			elif _pressed >= 0 and _pressed == stop:
				# A finger must be seen to be lifted before another window opens.
				_open_picker.call_deferred(stop)
			_pressed = -1
			_dragged = false
		queue_redraw()
		accept_event()
	elif button.button_index == MOUSE_BUTTON_RIGHT and button.pressed and stop >= 0:
		remove_handle(stop)
		accept_event()


func _on_motion(motion: InputEventMouseMotion) -> void:
	if _pressed < 0:
		hover(handle_at(motion))
		var value := value_at(motion.position.x)
		hinted.emit("%s    #%s" % [axis.text(value), transfer_function.get_color(value).to_html(false)])
		return
	if not _dragged and absf(motion.position.x - x_of(points.shown(points.color_values[_pressed]))) < scaled(3.0):
		return
	_dragged = true
	begin_edit()
	points.bake_window()
	points.move_stop(_pressed, value_at(motion.position.x))
	hinted.emit(axis.text(points.color_values[_pressed]))
	edited.emit()
	accept_event()


func _add(value: float) -> void:
	begin_edit()
	points.bake_window()
	hovered = points.add_stop(value, transfer_function.get_color(value))
	edited.emit()
	end_edit()


func _open_picker(stop: int) -> void:
	if not is_ready_to_edit() or stop >= points.colors.size():
		return
	if _popup == null:
		_popup = PopupPanel.new()
		_picker = ColorPicker.new()
		_picker.edit_alpha = false
		_picker.sampler_visible = false
		_picker.color_changed.connect(_on_color_changed)
		_remove_button = Button.new()
		_remove_button.text = "Remove This Colour"
		_remove_button.pressed.connect(_on_remove_pressed)
		var column := VBoxContainer.new()
		column.add_child(_picker)
		column.add_child(_remove_button)
		_popup.add_child(column)
		_popup.popup_hide.connect(_on_picker_closed)
		add_child(_popup)
	_picked = stop
	_picker.color = points.colors[stop]
	_remove_button.disabled = points.colors.size() <= 1
	_popup.reset_size()
	var anchor := get_screen_position() + Vector2(x_of(points.shown(points.color_values[stop])), 0.0)
	_popup.popup(Rect2i(Vector2i(anchor) - Vector2i(_popup.size.x >> 1, _popup.size.y), Vector2i.ZERO))


func _on_color_changed(color: Color) -> void:
	if _picked >= 0 and _picked < points.colors.size():
		begin_edit()
		points.colors[_picked] = Color(color, 1.0)
		edited.emit()
		queue_redraw()


func _on_picker_closed() -> void:
	_picked = -1
	end_edit()
	queue_redraw()


func _on_remove_pressed() -> void:
	var stop := _picked
	_popup.hide()
	remove_handle(stop)


func _draw() -> void:
	if not is_ready_to_edit():
		return
	var bar := Rect2(scaled(MARGIN), scaled(2.0), size.x - 2.0 * scaled(MARGIN), scaled(16.0))
	_draw_gradient(bar)
	for i in points.color_values.size():
		_draw_stop(i, bar)


func _draw_gradient(bar: Rect2) -> void:
	var xs := PackedFloat32Array([bar.position.x, bar.end.x])
	for value in points.color_values:
		var x := x_of(points.shown(value))
		if x > bar.position.x and x < bar.end.x:
			xs.append(x)
	# Colours mix in linear light: more samples than stops.
	for step in range(1, 64):
		xs.append(lerpf(bar.position.x, bar.end.x, step / 64.0))
	xs.sort()
	var vertices := PackedVector2Array()
	var fill := PackedColorArray()
	var indices := PackedInt32Array()
	for x in xs:
		var color := Color(transfer_function.get_color(value_at(x)), 1.0)
		vertices.append_array([Vector2(x, bar.position.y), Vector2(x, bar.end.y)])
		fill.append_array([color, color])
	for i in range(0, vertices.size() - 2, 2):
		indices.append_array([i, i + 1, i + 2, i + 1, i + 3, i + 2])
	RenderingServer.canvas_item_add_triangle_array(get_canvas_item(), indices, vertices, fill)


func _draw_stop(stop: int, bar: Rect2) -> void:
	var x := x_of(points.shown(points.color_values[stop]))
	if x < bar.position.x - 1.0 or x > bar.end.x + 1.0:
		return
	var active := stop == hovered or stop == _pressed or stop == _picked
	var half := scaled(6.0 if active else 5.0)
	var top := bar.end.y - scaled(1.0)
	var outline := accent() if active else Color(0.96, 0.96, 0.97)
	var shape := PackedVector2Array([
		Vector2(x, top), Vector2(x + half, top + half), Vector2(x + half, top + half * 2.6),
		Vector2(x - half, top + half * 2.6), Vector2(x - half, top + half),
	])
	draw_colored_polygon(shape, Color(points.colors[stop], 1.0))
	shape.append(shape[0])
	draw_polyline(shape, outline, scaled(1.4), true)
