extends Node3D
## What Godot's frames pay for scans that come and go, as `cargo bench -p lumivox-wgpu --bench arrivals` measures it
## without an engine. Prints a table and quits. `script/bench arrivals [VOXELS] [WIDTHxHEIGHT]` runs it, or
## `godot --path out/bench/godot --resolution 160x120 res://arrivals.tscn -- VOXELS [frames]`: VOXELS are those along a
## side of a scan (256), and with `frames` every frame of a change is printed as well.
##
## The window shows a small volume and goes on drawing, each frame of a new camera, while a scan is added, hidden, shown,
## lit anew and replaced. Of each change: the milliseconds until it is whole and the frames of them, the first frame, the
## longest, and what is usual, the median of those before, with the longest of them, which tells what else the machine
## did. A frame is the wall-clock time from the end of the one before. Then what textures took before the change and at
## most while it lasted, and what the voxels of all scans shown take. In MB.

## Frames before a change, and those that are looked at after it, be it whole sooner.
const FRAMES := 30
## Frames after which what was freed is gone.
const SETTLED := 12
## Milliseconds of frames before those that are looked at. Making a scan holds frames up for seconds, in which a GPU slows
## its clocks down, and what the change before did to the pace of tracing is over.
const AWAKE_MS := 2000
const PATIENCE := 5000
const BUDGET_MS := 4.0
const SMALL := 64
## Scans and the small volume are this large, in metres, and so far apart.
const SIDE := 0.2
const APART := 0.25

var _camera := Camera3D.new()
var _world := WorldEnvironment.new()
var _probe := SubViewport.new()
var _still := Transform3D()
var _moved := 0
var _last := 0
var _peak := 0.0
var _prints_frames := false


func _ready() -> void:
	var arguments := OS.get_cmdline_user_args()
	var size := 256
	for argument in arguments:
		size = argument.to_int() if argument.is_valid_int() else size
	_prints_frames = "frames" in arguments
	_build()
	var seen := get_viewport().get_visible_rect().size
	print("%s, Godot %s, %d^3, %d x %d, %.1f ms of tracing" % [RenderingServer.get_video_adapter_name(),
		Engine.get_version_info().string, size, seen.x, seen.y, BUDGET_MS])
	add_child(_shown(LumivoxVolume.phantom("cube", SMALL), 0.0))
	# Until here it is about kernels. Where there is one texture for all, this one leaves it, and a larger one does not fit.
	var warm := _shown(LumivoxVolume.phantom("cube", mini(size, 160)), APART)
	add_child(warm)
	await _until_whole()
	warm.free()
	await _until_whole()
	print("%-14s %6s %9s %9s %9s %9s %9s %9s %9s %9s" % ["change", "frames", "whole ms", "first", "longest", "usual",
		"at most", "before MB", "peak MB", "voxels MB"])

	var bytes := 2e-6 * float(size) ** 3
	var small := 2e-6 * float(SMALL) ** 3
	var scan := _shown(LumivoxVolume.phantom("cube", size), APART)
	await _row("add", small + bytes, add_child.bind(scan))
	await _row("hide", small, scan.hide)
	await _row("show", small + bytes, scan.show)
	await _row("light anew", small + bytes, func() -> void: _world.environment = _light(Color(0.5, 0.7, 1.0)))
	# Nobody else holds the one that goes.
	await _row("replace", small + bytes, scan.set_volume.bind(LumivoxVolume.phantom("cube", size)))
	if not Lumivox.last_error().is_empty():
		printerr(Lumivox.last_error())
	get_tree().quit()


func _build() -> void:
	_world.environment = _light(Color.WHITE)
	_world.compositor = _tracing(BUDGET_MS, 1 << 16)
	add_child(_world)
	var target := Vector3(0.5 * APART, 0.0, 0.0)
	var eye := target + Vector3(0.1, 0.1, 0.7)
	_still = Transform3D(Basis.looking_at(target - eye), eye)
	_camera.fov = 50.0
	_camera.transform = _still
	add_child(_camera)
	# A view at rest is done once all voxels are there, whatever that of the window does.
	_probe.size = Vector2i(8, 8)
	_probe.render_target_update_mode = SubViewport.UPDATE_ALWAYS
	var still := Camera3D.new()
	still.fov = _camera.fov
	still.transform = _still
	still.compositor = _tracing(BUDGET_MS, 1)
	_probe.add_child(still)
	add_child(_probe)


static func _tracing(budget: float, samples: int) -> Compositor:
	var effect := LumivoxEffect.new()
	effect.frame_budget_ms = budget
	effect.target_samples = samples
	var compositor := Compositor.new()
	compositor.compositor_effects = [effect]
	return compositor


## Of one colour, so that the engine draws no sky for it.
static func _light(color: Color) -> Environment:
	var environment := Environment.new()
	environment.background_mode = Environment.BG_COLOR
	environment.ambient_light_source = Environment.AMBIENT_SOURCE_COLOR
	environment.ambient_light_color = color
	environment.ambient_light_energy = 1.0
	return environment


static func _shown(volume: LumivoxVolume, x: float) -> LumivoxVolume3D:
	var node := LumivoxVolume3D.new()
	node.volume = volume
	node.apply_preset("ct-bone")
	node.scale = Vector3.ONE * SIDE / volume.get_size_m().x
	node.position.x = x
	return node


## A frame's milliseconds.
func _frame() -> float:
	_moved += 1
	# By a hair: a new image, as dear as any.
	_camera.transform = _still.translated(Vector3(_moved * 1e-6, 0.0, 0.0))
	await RenderingServer.frame_post_draw
	var now := Time.get_ticks_usec()
	var took := (now - _last) * 1e-3
	_last = now
	_peak = maxf(_peak, _textures())
	return took


static func _textures() -> float:
	return RenderingServer.get_rendering_device().get_memory_usage(RenderingDevice.MEMORY_TEXTURES) * 1e-6


func _is_whole() -> bool:
	return Lumivox.is_converged(_probe) and not Lumivox.get_status(_probe).is_empty()


func _until_whole() -> void:
	# A change is not known of before it was drawn.
	await _frame()
	for frame in PATIENCE:
		if _is_whole():
			break
		await _frame()
	for frame in SETTLED:
		await _frame()


func _row(what: String, voxels: float, change: Callable) -> void:
	var usual: Array[float] = []
	var woken := Time.get_ticks_msec()
	while Time.get_ticks_msec() - woken < AWAKE_MS:
		await _frame()
	for frame in FRAMES:
		usual.append(await _frame())
	usual.sort()
	var before := _textures()
	_peak = 0.0
	var begin := _last
	change.call()
	var frames: Array[float] = []
	var whole := 0.0
	var whole_frames := 0
	while frames.size() < PATIENCE and (whole == 0.0 or frames.size() < FRAMES):
		frames.append(await _frame())
		if _prints_frames:
			print("    %8.2f ms %8.1f MB %s %s" % [frames[-1], _textures(), Lumivox.get_status(_probe),
				Lumivox._get_stalls()])
		if whole == 0.0 and _is_whole():
			whole = (_last - begin) * 1e-3
			whole_frames = frames.size()
	print("%-14s %6d %9.1f %9.2f %9.2f %9.2f %9.2f %9.1f %9.1f %9.1f" % [what, whole_frames, whole, frames[0],
		frames.max(), usual[FRAMES / 2], usual[-1], before, _peak, voxels])
