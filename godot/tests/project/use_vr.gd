extends Node
## Uses the demo's VR scene in a headset with two hands that this moves, and tells what came of it.

const PATIENCE_FRAMES := 1500
## As many give the place of a noisy head, of so many samples each.
const PICTURES := 4
const SAMPLES := 16
const SCALE := 0.2

var _told := {}
var _scene: Node3D
var _head: LumivoxVolume3D
var _hands: Dictionary[String, XRControllerTracker] = {}


func _ready() -> void:
	var interface := XRServer.find_interface("OpenXR") as OpenXRInterface
	if interface == null or not interface.is_initialized():
		push_error("OpenXR did not start.")
		get_tree().quit(1)
		return
	interface.render_target_size_multiplier = SCALE
	for name: String in ["left_hand", "right_hand"]:
		var hand := XRControllerTracker.new()
		hand.name = name
		hand.hand = XRPositionalTracker.TRACKER_HAND_LEFT if name == "left_hand" else XRPositionalTracker.TRACKER_HAND_RIGHT
		XRServer.add_tracker(hand)
		_hands[name] = hand
	await _open()
	_told["eyes"] = await _look(interface, PICTURES)
	await _grab()
	await _scale()
	await _cut()
	await _close()
	_check("the flat view is back", not get_viewport().use_xr and DisplayServer.window_get_vsync_mode() == DisplayServer.VSYNC_ENABLED)
	await _open()
	_check("VR can be entered again", get_viewport().use_xr and (await _look(interface, 1)).size() == 2)
	await _close()
	print("TELL vr %s" % JSON.stringify(_told))
	get_tree().quit()


func _check(what: String, ok: bool) -> void:
	_told[what] = ok


func _frames(count: int) -> void:
	for frame in count:
		await RenderingServer.frame_post_draw


## The scene as the menu opens it, but for the size of its phantom.
func _open() -> void:
	_scene = (load("res://scenes/vr.tscn") as PackedScene).instantiate()
	var source := _scene.get_node("PhantomSource") as PhantomSource
	source.size = 48
	add_child(_scene)
	_head = _scene.get_node("Head") as LumivoxVolume3D
	if _head.volume == null:
		await source.grown
	await _frames(10)


func _close() -> void:
	_scene.queue_free()
	await _frames(20)


func _effect() -> LumivoxEffect:
	var compositor := (_scene.get_node("WorldEnvironment") as WorldEnvironment).compositor
	return compositor.compositor_effects[0] as LumivoxEffect


## Where each eye sees the head, in the mean of some pictures: its share of that, and the middle as the tangent of the angle to the right.
func _look(interface: OpenXRInterface, pictures_wanted: int) -> Array:
	# Nothing but the head, in one frame.
	for name: String in ["Floor", "Stand"]:
		(_scene.get_node(name) as Node3D).hide()
	var world := _scene.get_node("WorldEnvironment") as WorldEnvironment
	var environment := world.environment.duplicate() as Environment
	environment.background_mode = Environment.BG_COLOR
	environment.background_color = Color.BLACK
	environment.fog_enabled = false
	environment.glow_enabled = false
	world.environment = environment
	var effect := _effect()
	var resolution := effect.resolution_scale
	effect.target_samples = SAMPLES
	effect.resolution_scale = 1.0
	effect.frame_budget_ms = 10_000.0
	var pictures := EyePictures.new()
	world.compositor.compositor_effects += [pictures] as Array[CompositorEffect]
	var place := _head.global_transform
	var camera := _scene.get_node("XROrigin3D/XRCamera3D") as XRCamera3D
	for frame in PATIENCE_FRAMES:
		# Straight ahead, wherever the head turns to.
		_head.global_position = camera.global_transform * Vector3(0.0, 0.0, -0.8)
		await RenderingServer.frame_post_draw
		# It moves in every frame: whether no path lags behind a count would say too late.
		if frame >= 10 and Lumivox.get_status(get_viewport()).samples >= effect.target_samples:
			break
	# It moves, so each picture has a few samples only. Before the eyes it stands still: in the mean of many its dark side is seen, too.
	var seen := []
	var lights: Array[PackedFloat32Array] = []
	var size: Vector2i
	for picture in pictures_wanted:
		_head.global_position = camera.global_transform * Vector3(0.0, 0.0, -0.8)
		await RenderingServer.frame_post_draw
		var images := pictures.images()
		for view in images.size():
			size = images[view].get_size()
			if picture == 0:
				lights.append(PackedFloat32Array())
				lights[view].resize(size.x * size.y)
			for i in size.x * size.y:
				lights[view][i] += images[view].get_pixel(i % size.x, i / size.x).get_luminance() / pictures_wanted
	for view in lights.size():
		var projection := interface.get_projection_for_view(view, float(size.x) / size.y, camera.near, camera.far)
		var count := 0
		var sum := 0.0
		for i in size.x * size.y:
			if lights[view][i] > 0.001:
				count += 1
				sum += i % size.x
		var middle := 2.0 * (sum / maxi(count, 1) + 0.5) / size.x - 1.0
		seen.append({
			"share": float(count) / (size.x * size.y),
			"middle": (middle + projection.z.x) / projection.x.x,
		})
	world.compositor.compositor_effects = [effect] as Array[CompositorEffect]
	await _frames(2)
	pictures.free_all()
	_head.global_transform = place
	effect.frame_budget_ms = 5.0
	effect.resolution_scale = resolution
	effect.target_samples = 4
	return seen


func _put(name: String, place: Transform3D, grip := 0.0, trigger := 0.0) -> void:
	var hand := _hands[name]
	hand.set_pose("grip", place, Vector3.ZERO, Vector3.ZERO, XRPose.XR_TRACKING_CONFIDENCE_HIGH)
	hand.set_input("grip", grip)
	hand.set_input("trigger", trigger)


func _at(offset: Vector3, turn := Basis.IDENTITY) -> Transform3D:
	return Transform3D(turn, Vector3(0.0, 1.2, -0.6) + offset)


func _grab() -> void:
	var before := _head.global_transform
	# Beyond reach.
	_put("right_hand", _at(Vector3(1.0, 0.0, 0.0)), 1.0)
	await _frames(2)
	_put("right_hand", _at(Vector3(1.2, 0.0, 0.0)), 1.0)
	await _frames(2)
	_check("a hand that is too far holds nothing", _head.global_transform.is_equal_approx(before))
	var from := _at(Vector3(0.05, 0.0, 0.08))
	_put("right_hand", from)
	await _frames(2)
	_put("right_hand", from, 1.0)
	await _frames(2)
	_check("taking hold moves nothing", _head.global_transform.is_equal_approx(before))
	var to := _at(Vector3(0.2, 0.1, 0.0), Basis(Vector3.UP, 0.5))
	_put("right_hand", to, 1.0)
	await _frames(2)
	_check("a hand moves and turns the head", _head.global_transform.is_equal_approx(to * from.affine_inverse() * before))
	_put("right_hand", to)
	await _frames(2)
	var left := _head.global_transform
	_put("right_hand", _at(Vector3.ZERO))
	await _frames(2)
	_check("let go, it stays", _head.global_transform.is_equal_approx(left))
	_head.global_transform = before


func _scale() -> void:
	await _spread(0.1, 0.0)
	await _spread(0.1, 1.0)
	var before := _head.scale.x
	await _spread(0.2, 1.0)
	_check("two hands scale it", is_equal_approx(_head.scale.x, 2.0 * before))
	await _spread(3.0, 1.0)
	_check("it does not grow without end", is_equal_approx(_head.scale.x, 6.0))
	await _spread(0.01, 1.0)
	_check("nor vanish", is_equal_approx(_head.scale.x, 0.25))
	await _spread(0.01, 0.0)
	_head.global_transform = _at(Vector3.ZERO)


## Both hands, apart by twice a distance.
func _spread(half: float, grip: float) -> void:
	_put("left_hand", _at(Vector3(-half, 0.0, 0.0)), grip)
	_put("right_hand", _at(Vector3(half, 0.0, 0.0)), grip)
	await _frames(2)


func _cut() -> void:
	_put("left_hand", _at(Vector3(2.0, 0.0, 0.0)))
	# A controller points along its -z: from the front it moves the front face.
	var offset := Vector3(0.0, 0.0, 0.03)
	_put("right_hand", _at(offset), 0.0, 1.0)
	await _frames(2)
	var place := (_head.global_transform * _head.get_clip_transform()).affine_inverse()
	var wanted := (place * _at(offset).origin).z
	_check("a trigger cuts where the hand is", absf(_head.clip_max.z - wanted) < 1e-3 and wanted < 0.9)
	_check("and nothing else", _head.clip_min == Vector3.ZERO and _head.clip_max.x == 1.0 and _head.clip_max.y == 1.0)
	_put("right_hand", _at(offset))
	_hands["right_hand"].set_input("ax_button", true)
	await _frames(2)
	_check("a button takes the cut back", _head.clip_max == Vector3.ONE)
	_hands["right_hand"].set_input("ax_button", false)
