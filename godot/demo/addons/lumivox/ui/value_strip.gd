extends Control
## A strip of the transfer-function editor over the shared value axis: what zooming, panning and drawing have in common.

const Points := preload("transfer_function_points.gd")
const ValueAxis := preload("value_axis.gd")

## Emitted before the first change of a drag or click.
signal edit_started
## Emitted after every change of the points.
@warning_ignore("unused_signal")
signal edited
## Emitted when a drag or click is over.
signal edit_finished
## Emitted with a line on what is under the pointer.
@warning_ignore("unused_signal")
signal hinted(text: String)

## Zoom of one notch of the wheel.
const WHEEL_ZOOM := 1.2
## Pixels between the control's sides and the axis' ends.
const MARGIN := 14.0
## How near the pointer must be to a handle, in pixels.
const GRAB_DISTANCE := 11.0
## The same of a finger.
const TOUCH_DISTANCE := 26.0

## The shared axis.
var axis: ValueAxis
## The shared points.
var points: Points
## What the points belong to; it evaluates the curve.
var transfer_function: LumivoxTransferFunction
## The handle that the pointer is at, or -1.
var hovered := -1

var _panning := false
var _editing := false


func _init() -> void:
	clip_contents = true
	focus_mode = Control.FOCUS_CLICK
	mouse_exited.connect(_on_mouse_exited)


func _gui_input(event: InputEvent) -> void:
	if not is_ready_to_edit():
		return
	if navigate(event):
		accept_event()
	elif event is InputEventMouseButton:
		_on_button(event as InputEventMouseButton)
	elif event is InputEventMouseMotion:
		_on_motion(event as InputEventMouseMotion)
	elif event is InputEventKey and event.is_pressed():
		_on_key(event as InputEventKey)


func _on_button(_button: InputEventMouseButton) -> void:
	pass


func _on_motion(_motion: InputEventMouseMotion) -> void:
	pass


func _on_key(_key: InputEventKey) -> void:
	pass


## Pixels of the interface for a length at scale 1.
func scaled(length: float) -> float:
	return length * maxf(get_theme_default_base_scale(), 1.0)


## The pixel of a value.
func x_of(value: float) -> float:
	return axis.x_from_value(value, size.x, scaled(MARGIN))


## The value at a pixel.
func value_at(x: float) -> float:
	return axis.value_from_x(x, size.x, scaled(MARGIN))


## Whether there is something to edit.
func is_ready_to_edit() -> bool:
	return axis != null and points != null and transfer_function != null and not points.is_empty()


## Starts an edit once.
func begin_edit() -> void:
	if not _editing:
		_editing = true
		edit_started.emit()


## Ends an edit that was begun.
func end_edit() -> void:
	if _editing:
		_editing = false
		edit_finished.emit()


## Lets go of what is dragged, for the points became others. What was edited is nobody's step any more.
func drop() -> void:
	_editing = false
	hover(-1)


## How many handles there are to drag.
func handle_count() -> int:
	return 0


## How far a handle is from [param at], in pixels.
func handle_distance(_handle: int, _at: Vector2) -> float:
	return INF


## Removes what a handle stands for. Returns whether it could be.
func remove_point(_handle: int) -> bool:
	return false


## Removes a handle, as an edit of its own.
func remove_handle(handle: int) -> void:
	begin_edit()
	points.bake_window()
	if remove_point(handle):
		edited.emit()
	end_edit()
	hover(-1)


## The handle that a pointer or finger takes hold of, or -1.
func handle_at(event: InputEventMouse) -> int:
	var nearest := -1
	# Touches arrive as those of a mouse that there is not.
	var distance := scaled(TOUCH_DISTANCE if event.device == InputEvent.DEVICE_ID_EMULATION else GRAB_DISTANCE)
	for i in handle_count():
		var d := handle_distance(i, event.position)
		if d < distance:
			distance = d
			nearest = i
	return nearest


## Shows which handle the pointer is at.
func hover(handle: int) -> void:
	if handle != hovered:
		hovered = handle
		queue_redraw()


func _on_mouse_exited() -> void:
	hover(-1)
	hinted.emit("")


## Handles zoom and pan. Returns whether the event was one of them.
func navigate(event: InputEvent) -> bool:
	var button := event as InputEventMouseButton
	if button != null:
		var factor := pow(WHEEL_ZOOM, button.factor if button.factor > 0.0 else 1.0)
		match button.button_index:
			MOUSE_BUTTON_WHEEL_UP when button.pressed:
				axis.zoom(factor, value_at(button.position.x))
			MOUSE_BUTTON_WHEEL_DOWN when button.pressed:
				axis.zoom(1.0 / factor, value_at(button.position.x))
			MOUSE_BUTTON_WHEEL_LEFT when button.pressed:
				axis.pan((axis.view.x - axis.view.y) * 0.05)
			MOUSE_BUTTON_WHEEL_RIGHT when button.pressed:
				axis.pan((axis.view.y - axis.view.x) * 0.05)
			MOUSE_BUTTON_MIDDLE:
				_panning = button.pressed
			_:
				return false
		return true
	var motion := event as InputEventMouseMotion
	if motion != null and _panning:
		axis.pan(value_at(0.0) - value_at(motion.relative.x))
		return true
	var magnify := event as InputEventMagnifyGesture
	if magnify != null:
		axis.zoom(magnify.factor, value_at(magnify.position.x))
		return true
	var gesture := event as InputEventPanGesture
	if gesture != null:
		axis.pan(value_at(gesture.delta.x * 8.0) - value_at(0.0))
		return true
	return false


## The theme's text colour, as faint as asked for.
func ink(alpha: float) -> Color:
	return Color(get_theme_color(&"font_color", &"Label"), alpha)


## The theme's accent.
func accent() -> Color:
	if has_theme_color(&"accent_color", &"Editor"):
		return get_theme_color(&"accent_color", &"Editor")
	if has_theme_color(&"accent_color", &"LumivoxEditor"):
		return get_theme_color(&"accent_color", &"LumivoxEditor")
	return Color(0.95, 0.62, 0.42)


## The ground that the strips are drawn on.
func ground() -> Color:
	if has_theme_color(&"dark_color_2", &"Editor"):
		return get_theme_color(&"dark_color_2", &"Editor")
	return Color(0.07, 0.08, 0.1, 0.85)
