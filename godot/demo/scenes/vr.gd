extends "demo_scene.gd"
## The head in VR: grab it with one hand, scale it with two, cut it with a controller.
##
## Without a headset, or where the project was not started for one, a flat view with a note takes over.

## Squeezed beyond this a hand holds.
const GRIP := 0.6
## Farther than this from the volume's box a hand does not reach, in metres.
const REACH := 0.12
const MIN_SCALE := 0.25
const MAX_SCALE := 6.0

@onready var _head: LumivoxVolume3D = $Head
@onready var _origin: XROrigin3D = $XROrigin3D
@onready var _left: XRController3D = $XROrigin3D/Left
@onready var _right: XRController3D = $XROrigin3D/Right
@onready var _flat: LumivoxOrbitCamera = $FlatCamera
@onready var _note: Control = $Note/Ground
@onready var _reason: Label = %Reason
@onready var _restart: Button = %Restart

var _holding: Array[XRController3D] = []
## The volume in the frame of the one hand, or of both together, when they took hold.
var _held := Transform3D.IDENTITY
## What the window waited for before.
var _vsync := DisplayServer.VSYNC_ENABLED


func _ready() -> void:
	_restart.pressed.connect(_restart_in_vr)
	_note.theme = preload("res://addons/lumivox/ui/panel_theme.gd").create()
	var interface := XRServer.find_interface("OpenXR")
	if interface != null and (interface.is_initialized() or interface.initialize()):
		_enter_vr()
	else:
		_stay_flat()
	super()


## A headset waits for no frame.
func _lighten() -> void:
	if not get_viewport().use_xr:
		super()


func _exit_tree() -> void:
	if get_viewport().use_xr:
		_leave_vr()


func _process(_delta: float) -> void:
	if not get_viewport().use_xr:
		return
	var hands: Array[XRController3D] = []
	for hand: XRController3D in [_left, _right]:
		if hand.get_is_active() and hand.get_float(&"grip") > GRIP and (hand in _holding or _reaches(hand)):
			hands.append(hand)
	if hands != _holding:
		_holding = hands
		if not hands.is_empty():
			_held = _grip_frame().affine_inverse() * _head.global_transform
	elif not hands.is_empty():
		_head.global_transform = _grip_frame() * _held
		_limit_scale()
	for hand: XRController3D in [_left, _right]:
		if hand.get_is_active() and hand.get_float(&"trigger") > GRIP:
			_cut(hand)
		elif hand.is_button_pressed(&"ax_button"):
			_head.clip_min = Vector3.ZERO
			_head.clip_max = Vector3.ONE


func _enter_vr() -> void:
	# The headset keeps the time.
	_vsync = DisplayServer.window_get_vsync_mode()
	DisplayServer.window_set_vsync_mode(DisplayServer.VSYNC_DISABLED)
	get_viewport().use_xr = true
	_flat.current = false
	($XROrigin3D/XRCamera3D as XRCamera3D).current = true
	_note.hide()
	($Menu as CanvasLayer).hide()


## For the scene that comes next.
func _leave_vr() -> void:
	var viewport := get_window()
	viewport.use_xr = false
	# The engine (4.6) keeps a target with a layer for each eye, and fails to draw to it, until the size changes.
	RenderingServer.viewport_set_size(viewport.get_viewport_rid(), 2, 2)
	RenderingServer.viewport_set_size(viewport.get_viewport_rid(), viewport.size.x, viewport.size.y)
	DisplayServer.window_set_vsync_mode(_vsync)


func _stay_flat() -> void:
	_origin.hide()
	_flat.current = true
	var on := "--xr-mode" in OS.get_cmdline_args() \
			or ProjectSettings.get_setting_with_override(&"xr/openxr/enabled") as bool
	_restart.visible = not on and OS.has_feature("pc")
	if not on:
		_reason.text = "OpenXR is off in this run, so that the other scenes leave the headset alone."
	else:
		_reason.text = "No OpenXR runtime answered. Start SteamVR, Monado or the headset's own application and try again."


func _restart_in_vr() -> void:
	var arguments := PackedStringArray(["--xr-mode", "on", scene_file_path])
	if OS.has_feature("editor"):
		arguments = PackedStringArray(["--path", ProjectSettings.globalize_path("res://")]) + arguments
	if OS.create_process(OS.get_executable_path(), arguments) > 0:
		get_tree().quit()
	else:
		_reason.text = "The program could not be started again. Start it with --xr-mode on."


## Whether a hand is near enough to take hold.
func _reaches(hand: XRController3D) -> bool:
	var at := _head.global_transform.affine_inverse() * hand.global_position
	var box := _head.get_local_box()
	var nearest := at.clamp(box.position, box.end)
	return (_head.global_transform.basis * (at - nearest)).length() < REACH


## One hand's frame, or one that spans both: its scale is their distance.
func _grip_frame() -> Transform3D:
	if _holding.size() == 1:
		return _holding[0].global_transform
	var a := _holding[0].global_position
	var b := _holding[1].global_position
	var along := b - a
	var length := maxf(along.length(), 0.01)
	var up := (_holding[0].global_basis.y + _holding[1].global_basis.y).normalized()
	if absf(up.dot(along / length)) > 0.99:
		up = _holding[0].global_basis.z
	var frame := Basis.looking_at(along, up)
	return Transform3D(frame.scaled(Vector3.ONE * length), (a + b) / 2.0)


func _limit_scale() -> void:
	var size := _head.scale.x
	if size < MIN_SCALE or size > MAX_SCALE:
		_head.scale = Vector3.ONE * clampf(size, MIN_SCALE, MAX_SCALE)
		_held = _grip_frame().affine_inverse() * _head.global_transform


## Moves the face of the clip box that the controller points at to where it is.
func _cut(hand: XRController3D) -> void:
	var to_clip := (_head.global_transform * _head.get_clip_transform()).affine_inverse()
	var at := to_clip * hand.global_position
	var pointing := (to_clip.basis * -hand.global_basis.z).normalized()
	var axis := pointing.abs().max_axis_index()
	if pointing[axis] > 0.0:
		var low := _head.clip_min
		low[axis] = clampf(at[axis], 0.0, _head.clip_max[axis] - 0.01)
		_head.clip_min = low
	else:
		var high := _head.clip_max
		high[axis] = clampf(at[axis], _head.clip_min[axis] + 0.01, 1.0)
		_head.clip_max = high
