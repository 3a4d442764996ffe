@tool
extends "value_strip.gd"
## The window of a transfer function as a bar: drag it to shift all values, drag its ends to widen or narrow it.

enum Part { NONE = -1, BODY, LOW, HIGH }

var _pressed := Part.NONE
var _start_x := 0.0
var _start := Vector2.ZERO


func _init() -> void:
	super()
	custom_minimum_size = Vector2(0.0, 16.0)


func _enter_tree() -> void:
	custom_minimum_size.y = scaled(16.0)


func _on_button(button: InputEventMouseButton) -> void:
	if button.button_index != MOUSE_BUTTON_LEFT:
		return
	if button.pressed:
		_pressed = _part_at(button)
		_start_x = button.position.x
		_start = points.value_range()
	else:
		_pressed = Part.NONE
		end_edit()
	queue_redraw()
	accept_event()


func _on_motion(motion: InputEventMouseMotion) -> void:
	if _pressed == Part.NONE:
		var part := _part_at(motion)
		mouse_default_cursor_shape = Control.CURSOR_HSIZE if part in [Part.LOW, Part.HIGH] \
				else Control.CURSOR_MOVE if part == Part.BODY else Control.CURSOR_ARROW
		hover(part)
	else:
		_drag(value_at(motion.position.x) - value_at(_start_x))
		accept_event()


func drop() -> void:
	_pressed = Part.NONE
	super()


func _drag(by: float) -> void:
	begin_edit()
	var low := _start.x
	var high := _start.y
	match _pressed:
		Part.BODY:
			low += by
			high += by
		Part.LOW: low = minf(low + by, high - (axis.full.y - axis.full.x) * 1e-3)
		Part.HIGH: high = maxf(high + by, low + (axis.full.y - axis.full.x) * 1e-3)
	points.set_window((low + high) / 2.0, high - low)
	hinted.emit("%s to %s" % [axis.text(low), axis.text(high)])
	edited.emit()


func handle_count() -> int:
	return 2


func handle_distance(handle: int, at: Vector2) -> float:
	return absf(at.x - x_of(points.value_range()[handle]))


func _part_at(event: InputEventMouse) -> Part:
	match handle_at(event):
		0: return Part.LOW
		1: return Part.HIGH
	var shown := points.value_range()
	return Part.BODY if event.position.x > x_of(shown.x) and event.position.x < x_of(shown.y) else Part.NONE


func _draw() -> void:
	if not is_ready_to_edit():
		return
	var shown := points.value_range()
	var y := size.y / 2.0
	var low := clampf(x_of(shown.x), scaled(MARGIN), size.x - scaled(MARGIN))
	var high := clampf(x_of(shown.y), scaled(MARGIN), size.x - scaled(MARGIN))
	draw_line(Vector2(scaled(MARGIN), y), Vector2(size.x - scaled(MARGIN), y), ink(0.14), scaled(2.0))
	var strong := hovered != Part.NONE or _pressed != Part.NONE
	draw_line(Vector2(low, y), Vector2(high, y), Color(accent(), 1.0 if strong else 0.75), scaled(4.0))
	for x: float in [x_of(shown.x), x_of(shown.y)]:
		if x >= scaled(MARGIN) - 1.0 and x <= size.x - scaled(MARGIN) + 1.0:
			var knob := Rect2(x - scaled(2.5), y - scaled(6.0), scaled(5.0), scaled(12.0))
			draw_rect(knob, Color(0.96, 0.96, 0.97))
