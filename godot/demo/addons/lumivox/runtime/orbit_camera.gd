@icon("../icons/lumivox_orbit_camera.svg")
class_name LumivoxOrbitCamera
extends Camera3D
## A camera that circles around a point, by mouse and by touch.
##
## Left drag turns, middle or right drag (or Shift and left) pans, the wheel zooms; one finger turns, two pan and zoom.
## F frames the target again. It stands still when nobody moves it, so that an image can converge.

## What F and [method frame_target] frame; null keeps the given pivot.
@export var target: VisualInstance3D
## The point that the camera looks at.
@export var pivot := Vector3.ZERO
## Metres between camera and pivot.
@export_range(0.01, 100.0, 0.001, "or_greater", "suffix:m") var distance := 1.0
## Angle about the vertical axis; 0 looks from +z.
@export_range(-180.0, 180.0, 0.1, "radians_as_degrees") var azimuth := 0.0
## Angle above the horizon.
@export_range(-89.0, 89.0, 0.1, "radians_as_degrees") var elevation := 0.2
## The nearest that zooming goes.
@export_range(0.001, 10.0, 0.001, "suffix:m") var min_distance := 0.05
## The farthest that zooming goes.
@export_range(0.1, 1000.0, 0.1, "suffix:m") var max_distance := 20.0
## The lowest that the camera turns.
@export_range(-89.0, 89.0, 0.1, "radians_as_degrees") var min_elevation := -1.4
## How fast it follows the hand: 1 / e of the way is left after 1 / this seconds. 0 follows at once.
@export_range(0.0, 60.0, 0.1) var smoothing := 18.0
## Radians per pixel.
@export var turn_speed := 0.006
## Part of the screen's width that a panel covers on the right: the pivot is shown in the middle of what is left.
@export_range(0.0, 0.9, 0.01) var covered_right := 0.0

var _shown := Vector3.ZERO
var _shown_pivot := Vector3.ZERO
var _touches: Dictionary[int, Vector2] = {}


func _ready() -> void:
	jump()


## Goes to where it is heading at once.
func jump() -> void:
	_shown = Vector3(azimuth, elevation, distance)
	_shown_pivot = pivot
	_place()


## Frames [member target].
func frame_target() -> void:
	if target != null:
		frame(target.global_transform * target.get_aabb())


## Looks at the middle of [param box] from where all of it is seen.
func frame(box: AABB) -> void:
	pivot = box.get_center()
	var aspect := get_viewport().get_visible_rect().size.aspect() * (1.0 - covered_right)
	var half := tan(deg_to_rad(fov) / 2.0) * minf(aspect, 1.0)
	distance = clampf(box.size.length() / 2.0 / sin(atan(half)), min_distance, max_distance)


func _process(delta: float) -> void:
	var goal := Vector3(azimuth, elevation, distance)
	if _shown == goal and _shown_pivot == pivot:
		return
	var weight := 1.0 - exp(-smoothing * delta) if smoothing > 0.0 else 1.0
	_shown = _shown.lerp(goal, weight)
	_shown_pivot = _shown_pivot.lerp(pivot, weight)
	# An endless approach would never let an image converge.
	if _shown.distance_to(goal) < 1e-4 and _shown_pivot.distance_to(pivot) < 1e-5 * distance:
		_shown = goal
		_shown_pivot = pivot
	_place()


func _place() -> void:
	var turn := Basis.from_euler(Vector3(-_shown.y, _shown.x, 0.0))
	global_transform = Transform3D(turn, _shown_pivot + turn.z * _shown.z)
	# Half of what is covered, in metres at the pivot.
	var aspect := get_viewport().get_visible_rect().size.aspect()
	h_offset = covered_right * _shown.z * tan(deg_to_rad(fov) / 2.0) * aspect


## A finger may be lifted over a panel, which keeps that to itself.
func _input(event: InputEvent) -> void:
	var touch := event as InputEventScreenTouch
	if touch != null and not touch.pressed:
		_touches.erase(touch.index)


func _unhandled_input(event: InputEvent) -> void:
	if not current:
		return
	if event is InputEventScreenTouch and event.is_pressed():
		_touches[(event as InputEventScreenTouch).index] = (event as InputEventScreenTouch).position
	elif event is InputEventScreenDrag:
		_on_touch_drag(event as InputEventScreenDrag)
	elif event is InputEventMouseButton and _touches.is_empty():
		_on_wheel(event as InputEventMouseButton)
	elif event is InputEventMouseMotion and _touches.is_empty():
		_on_motion(event as InputEventMouseMotion)
	elif event is InputEventMagnifyGesture:
		_zoom((event as InputEventMagnifyGesture).factor)
	elif event is InputEventPanGesture:
		_turn((event as InputEventPanGesture).delta * 10.0)
	elif event is InputEventKey and event.is_pressed() and (event as InputEventKey).keycode == KEY_F:
		frame_target()


func _on_wheel(button: InputEventMouseButton) -> void:
	if not button.pressed:
		return
	if button.button_index == MOUSE_BUTTON_WHEEL_UP:
		_zoom(1.12)
	elif button.button_index == MOUSE_BUTTON_WHEEL_DOWN:
		_zoom(1.0 / 1.12)


func _on_motion(motion: InputEventMouseMotion) -> void:
	var left := motion.button_mask & MOUSE_BUTTON_MASK_LEFT != 0
	var other := motion.button_mask & (MOUSE_BUTTON_MASK_MIDDLE | MOUSE_BUTTON_MASK_RIGHT) != 0
	if other or (left and motion.shift_pressed):
		_pan(motion.relative)
	elif left:
		_turn(motion.relative)


func _on_touch_drag(drag: InputEventScreenDrag) -> void:
	# Not one that began on a panel.
	if not _touches.has(drag.index):
		return
	var before := _spread()
	_touches[drag.index] = drag.position
	if _touches.size() == 1:
		_turn(drag.relative)
	elif _touches.size() == 2:
		_pan(drag.relative / 2.0)
		if before > 0.0:
			_zoom(_spread() / before)


func _spread() -> float:
	var fingers: Array[Vector2] = _touches.values()
	return fingers[0].distance_to(fingers[1]) if fingers.size() == 2 else 0.0


func _turn(pixels: Vector2) -> void:
	azimuth -= pixels.x * turn_speed
	elevation = clampf(elevation + pixels.y * turn_speed, min_elevation, 1.55)


func _pan(pixels: Vector2) -> void:
	var metres := 2.0 * distance * tan(deg_to_rad(fov) / 2.0) / get_viewport().get_visible_rect().size.y
	pivot += (basis.y * pixels.y - basis.x * pixels.x) * metres


func _zoom(factor: float) -> void:
	distance = clampf(distance / factor, min_distance, max_distance)
