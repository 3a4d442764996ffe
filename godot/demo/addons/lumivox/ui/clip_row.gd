extends HBoxContainer
## One axis of a clip box: a bar with two ends to drag.

## Emitted when an end was moved; both are between 0 and 1.
signal range_changed(low: float, high: float)

## The least that stays visible.
const MIN_EXTENT := 0.005
## Pixels between the bar's sides and its ends, for the knobs.
const MARGIN := 7.0

var _bar := Control.new()
var _range := Vector2(0.0, 1.0)
var _dragged := -1
var _start := 0.0
var _start_range := Vector2.ZERO


## A row of that title with a letter at each end.
func _init(title: String, low_letter: String, high_letter: String) -> void:
	var label := _letter(title, 72.0)
	label.horizontal_alignment = HORIZONTAL_ALIGNMENT_LEFT
	add_child(label)
	add_child(_letter(low_letter, 14.0))
	_bar.size_flags_horizontal = Control.SIZE_EXPAND_FILL
	_bar.custom_minimum_size.y = 20.0
	_bar.mouse_default_cursor_shape = Control.CURSOR_HSIZE
	_bar.draw.connect(_on_draw)
	_bar.gui_input.connect(_on_input)
	add_child(_bar)
	add_child(_letter(high_letter, 14.0))


## Shows a range without a signal.
func show_range(low: float, high: float) -> void:
	_range = Vector2(low, high)
	_bar.queue_redraw()


func _letter(text: String, width: float) -> Label:
	var label := Label.new()
	label.text = text
	label.custom_minimum_size.x = width
	label.horizontal_alignment = HORIZONTAL_ALIGNMENT_CENTER
	label.modulate.a = 0.8
	return label


func _on_input(event: InputEvent) -> void:
	var button := event as InputEventMouseButton
	if button != null and button.button_index == MOUSE_BUTTON_LEFT:
		_dragged = _part_at(button.position.x) if button.pressed else -1
		_start = button.position.x
		_start_range = _range
		if button.pressed and button.double_click:
			_show(Vector2(0.0, 1.0))
		_bar.queue_redraw()
		_bar.accept_event()
	var motion := event as InputEventMouseMotion
	if motion == null or _dragged < 0:
		return
	var by := (motion.position.x - _start) / _length()
	var next := _start_range
	match _dragged:
		0: next.x = clampf(next.x + by, 0.0, next.y - MIN_EXTENT)
		1: next.y = clampf(next.y + by, next.x + MIN_EXTENT, 1.0)
		2: next += Vector2.ONE * clampf(by, -next.x, 1.0 - next.y)
	_show(next)
	_bar.accept_event()


func _show(next: Vector2) -> void:
	if next != _range:
		_range = next
		_bar.queue_redraw()
		range_changed.emit(_range.x, _range.y)


func _part_at(x: float) -> int:
	var at := (x - MARGIN) / _length()
	var low := absf(at - _range.x)
	var high := absf(at - _range.y)
	if minf(low, high) * _length() > 2.0 * MARGIN and at > _range.x and at < _range.y:
		return 2
	return 0 if low < high else 1


func _on_draw() -> void:
	var accent := _bar.get_theme_color(&"accent_color", &"LumivoxEditor")
	var y := _bar.size.y / 2.0
	var low := MARGIN + _range.x * _length()
	var high := MARGIN + _range.y * _length()
	_bar.draw_line(Vector2(MARGIN, y), Vector2(_bar.size.x - MARGIN, y), Color(1.0, 1.0, 1.0, 0.12), 4.0)
	_bar.draw_line(Vector2(low, y), Vector2(high, y), Color(accent, 0.85), 4.0)
	for x: float in [low, high]:
		_bar.draw_circle(Vector2(x, y), 6.5, Color(0.93, 0.94, 0.95), true, -1.0, true)


func _length() -> float:
	return maxf(_bar.size.x - 2.0 * MARGIN, 1.0)
