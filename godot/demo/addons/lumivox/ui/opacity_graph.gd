@tool
extends "value_strip.gd"
## Opacity over physical values: the volume's histogram, the curve in its colours, and knots to drag.
##
## Double-click adds a knot, Delete or a right click removes it, a right click on the curve changes its ease.

## Emitted when another knot is the one that keys act on, or none: -1.
signal knot_selected(knot: int)

## Opacities shown larger than they are, so that thin tissue can be edited: y is opacity to the power of 1 / this.
var emphasis := 1.0:
	set(value):
		emphasis = value
		queue_redraw()

## Counts per bin over [member histogram_range].
var histogram := PackedFloat32Array():
	set(value):
		histogram = value
		queue_redraw()
## Values of the histogram's first and last edge.
var histogram_range := Vector2(0.0, 1.0)

## The knot that keys act on, or -1.
var selected := -1:
	set(value):
		selected = value
		knot_selected.emit(value)
		queue_redraw()

var _dragged := -1
var _grab_offset := Vector2.ZERO
var _menu: PopupMenu
var _menu_segment := -1


func _init() -> void:
	super()
	focus_mode = Control.FOCUS_ALL
	custom_minimum_size = Vector2(220.0, 110.0)
	size_flags_vertical = Control.SIZE_EXPAND_FILL
	focus_entered.connect(queue_redraw)
	focus_exited.connect(queue_redraw)


func _gui_input(event: InputEvent) -> void:
	if is_ready_to_edit():
		super(event)
		return
	var button := event as InputEventMouseButton
	# There is no point yet.
	if transfer_function != null and button != null and button.pressed and button.button_index == MOUSE_BUTTON_LEFT:
		_on_button(button)


func handle_count() -> int:
	return points.knots.size()


func handle_distance(knot: int, at: Vector2) -> float:
	return _position_of(knot).distance_to(at)


func remove_point(knot: int) -> bool:
	return points.remove_knot(knot)


func remove_handle(knot: int) -> void:
	super(knot)
	selected = -1


func drop() -> void:
	_dragged = -1
	super()
	if selected >= points.knots.size():
		selected = -1


## Removes the knot that keys act on.
func remove_selected() -> void:
	if selected >= 0 and selected < points.knots.size():
		remove_handle(selected)


func _on_button(button: InputEventMouseButton) -> void:
	if button.button_index == MOUSE_BUTTON_LEFT and not button.pressed:
		_dragged = -1
		end_edit()
		queue_redraw()
		return
	if not button.pressed:
		return
	var knot := handle_at(button)
	if button.button_index == MOUSE_BUTTON_LEFT:
		grab_focus()
		if knot < 0 and (button.double_click or button.ctrl_pressed):
			begin_edit()
			points.bake_window()
			knot = points.add_knot(_point_at(button.position))
			if points.color_values.is_empty():
				points.add_stop(points.knots[knot].x, Color.WHITE)
			edited.emit()
		if knot >= 0:
			_dragged = knot
			_grab_offset = _position_of(knot) - button.position
		selected = knot
		queue_redraw()
		accept_event()
	elif button.button_index == MOUSE_BUTTON_RIGHT:
		if knot >= 0:
			remove_handle(knot)
		else:
			_open_menu(button.position)
		accept_event()


func _on_motion(motion: InputEventMouseMotion) -> void:
	if _dragged < 0:
		hover(handle_at(motion))
		var at := _point_at(motion.position)
		hinted.emit("%s    opacity %.3f" % [axis.text(at.x), transfer_function.get_opacity(at.x)])
		return
	begin_edit()
	points.bake_window()
	var target := _point_at(motion.position + _grab_offset)
	if motion.shift_pressed:
		target.x = points.knots[_dragged].x
	points.move_knot(_dragged, target)
	var knot := points.knots[_dragged]
	hinted.emit("%s    opacity %.3f" % [axis.text(knot.x), knot.y])
	edited.emit()
	accept_event()


func _on_key(key: InputEventKey) -> void:
	if selected < 0 or selected >= points.knots.size():
		return
	var value_step := (axis.view.y - axis.view.x) / 400.0 * (5.0 if key.shift_pressed else 1.0)
	var opacity_step := 0.05 if key.shift_pressed else 0.01
	var step := Vector2.ZERO
	match key.keycode:
		KEY_DELETE, KEY_BACKSPACE:
			remove_handle(selected)
			accept_event()
			return
		KEY_LEFT: step.x = -value_step
		KEY_RIGHT: step.x = value_step
		KEY_UP: step.y = opacity_step
		KEY_DOWN: step.y = -opacity_step
		_: return
	begin_edit()
	points.bake_window()
	points.move_knot(selected, points.knots[selected] + step)
	edited.emit()
	end_edit()
	accept_event()


func _open_menu(at: Vector2) -> void:
	if _menu == null:
		_menu = PopupMenu.new()
		_menu.id_pressed.connect(_on_menu)
		add_child(_menu)
	_menu_segment = _stored_segment_at(value_at(at.x))
	_menu.clear()
	_menu.add_item("Add knot here", 0)
	_menu.set_item_metadata(0, _point_at(at))
	_menu.add_separator()
	_menu.add_radio_check_item("Straight segment", 1)
	_menu.add_radio_check_item("Ease in and out", 2)
	for item: int in [2, 3]:
		_menu.set_item_disabled(item, _menu_segment < 0)
		_menu.set_item_checked(item, _menu_segment >= 0 and points.eases[_menu_segment] == item - 2)
	_menu.add_separator()
	_menu.add_item("Straight everywhere", 3)
	_menu.add_item("Ease everywhere", 4)
	_menu.reset_size()
	_menu.position = Vector2i(get_screen_position() + at)
	_menu.popup()


func _on_menu(id: int) -> void:
	if id in [1, 2] and _menu_segment >= points.eases.size():
		return
	begin_edit()
	match id:
		0:
			points.bake_window()
			var point: Vector2 = _menu.get_item_metadata(0)
			selected = points.add_knot(point)
		1, 2: points.eases[_menu_segment] = id - 1
		3, 4: points.eases.fill(id - 3)
	edited.emit()
	end_edit()


func _stored_segment_at(value: float) -> int:
	for i in range(points.knots.size() - 1):
		if value >= points.shown(points.knots[i].x) and value < points.shown(points.knots[i + 1].x):
			return i
	return -1


func _plot() -> Rect2:
	var top := scaled(10.0)
	return Rect2(scaled(MARGIN), top, size.x - 2.0 * scaled(MARGIN), size.y - top - scaled(20.0))


func _y_of(opacity: float) -> float:
	var plot := _plot()
	return plot.end.y - pow(opacity, 1.0 / emphasis) * plot.size.y


func _point_at(at: Vector2) -> Vector2:
	var plot := _plot()
	var height := clampf((plot.end.y - at.y) / maxf(plot.size.y, 1.0), 0.0, 1.0)
	return Vector2(value_at(at.x), pow(height, emphasis))


func _position_of(knot: int) -> Vector2:
	return Vector2(x_of(points.shown(points.knots[knot].x)), _y_of(points.knots[knot].y))


func _draw() -> void:
	var box := StyleBoxFlat.new()
	box.bg_color = ground()
	box.set_corner_radius_all(int(scaled(4.0)))
	draw_style_box(box, Rect2(Vector2.ZERO, size))
	if not is_ready_to_edit():
		if transfer_function != null:
			_draw_invitation()
		return
	_draw_grid()
	_draw_histogram()
	_draw_curve()
	_draw_knots()


func _draw_invitation() -> void:
	var at := Vector2(scaled(MARGIN), size.y / 2.0)
	draw_string(get_theme_default_font(), at, "Double-click to add the first knot, or choose a preset.",
			HORIZONTAL_ALIGNMENT_CENTER, size.x - 2.0 * at.x, int(scaled(13.0)), ink(0.6))


func _draw_grid() -> void:
	var plot := _plot()
	var font := get_theme_default_font()
	var font_size := int(scaled(10.0))
	for step in 5:
		var y := _y_of(step / 4.0)
		draw_line(Vector2(plot.position.x, y), Vector2(plot.end.x, y), ink(0.16 if step == 0 else 0.07))
	for value in axis.ticks(int(plot.size.x / scaled(80.0))):
		var x := x_of(value)
		draw_line(Vector2(x, plot.position.y), Vector2(x, plot.end.y + scaled(3.0)), ink(0.07))
		var label := axis.text(value, false)
		var width := font.get_string_size(label, HORIZONTAL_ALIGNMENT_LEFT, -1, font_size).x
		var left := clampf(x - width / 2.0, 2.0, size.x - width - 2.0)
		draw_string(font, Vector2(left, size.y - scaled(5.0)), label, HORIZONTAL_ALIGNMENT_LEFT, -1, font_size, ink(0.55))


## Counts on a log scale: air outnumbers everything else by far.
func _draw_histogram() -> void:
	if histogram.is_empty():
		return
	var highest := 0.0
	for count in histogram:
		highest = maxf(highest, count)
	if highest <= 0.0:
		return
	var plot := _plot()
	var bin_width := (histogram_range.y - histogram_range.x) / histogram.size()
	var vertices := PackedVector2Array()
	for i in histogram.size():
		var x := x_of(histogram_range.x + (i + 0.5) * bin_width)
		if x < plot.position.x - 8.0 or x > plot.end.x + 8.0:
			continue
		var height := log(1.0 + histogram[i]) / log(1.0 + highest) * plot.size.y * 0.94
		vertices.append(Vector2(x, plot.end.y))
		vertices.append(Vector2(x, plot.end.y - height))
	var fill := PackedColorArray()
	fill.resize(vertices.size())
	fill.fill(ink(0.13))
	_fill_between(vertices, fill)


func _draw_curve() -> void:
	var plot := _plot()
	var xs := PackedFloat32Array()
	var step := scaled(2.0)
	var x := plot.position.x
	while x < plot.end.x:
		xs.append(x)
		x += step
	xs.append(plot.end.x)
	for knot in points.knots:
		var at := x_of(points.shown(knot.x))
		if at > plot.position.x and at < plot.end.x:
			xs.append(at)
	xs.sort()
	var curve := PackedVector2Array()
	var vertices := PackedVector2Array()
	var fill := PackedColorArray()
	for at in xs:
		var value := value_at(at)
		var top := Vector2(at, _y_of(transfer_function.get_opacity(value)))
		var color := transfer_function.get_color(value)
		curve.append(top)
		vertices.append(Vector2(at, plot.end.y))
		vertices.append(top)
		fill.append(Color(color, 0.22))
		fill.append(Color(color, 0.72))
	_fill_between(vertices, fill)
	draw_polyline(curve, ink(0.95), scaled(1.6), true)


## Fills the band between pairs of vertices (bottom, top).
func _fill_between(vertices: PackedVector2Array, fill: PackedColorArray) -> void:
	var indices := PackedInt32Array()
	for i in range(0, vertices.size() - 2, 2):
		indices.append_array([i, i + 1, i + 2, i + 1, i + 3, i + 2])
	if not indices.is_empty():
		RenderingServer.canvas_item_add_triangle_array(get_canvas_item(), indices, vertices, fill)


func _draw_knots() -> void:
	var focus := has_focus()
	for i in points.knots.size():
		var at := _position_of(i)
		if at.x < -8.0 or at.x > size.x + 8.0:
			continue
		var active := i == selected or i == _dragged
		var radius := scaled(6.5 if active or i == hovered else 5.0)
		draw_circle(at, radius + scaled(1.5), Color(0.0, 0.0, 0.0, 0.55), true, -1.0, true)
		draw_circle(at, radius, accent() if active else Color(0.96, 0.96, 0.97), true, -1.0, true)
		draw_circle(at, radius - scaled(2.2), Color(transfer_function.get_color(points.shown(points.knots[i].x)), 1.0), true, -1.0, true)
		if active and focus:
			draw_arc(at, radius + scaled(3.5), 0.0, TAU, 32, Color(accent(), 0.7), scaled(1.2), true)
