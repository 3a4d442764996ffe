extends Node3D
## What the addon costs in Godot's frame: the phantom head of `cargo bench -p lumivox-wgpu --bench live`, seen from the same
## place, in an otherwise empty scene. Prints a table and quits.
##
## `frame` is the median wall-clock time between frames, `gpu` the median of the GPU's own time for the viewport, `tracing`
## what the addon measures of its tracing passes, `sample` that time scaled to one sample for every pixel.

## Frames that a row is the median of, and frames before them that are not looked at.
const FRAMES := 60
const WARM_UP := 90

## As framing::frame() says for an azimuth of 0.4 and an elevation of 0.1; the bench of the renderer prints it.
const EYE := Vector3(0.292, 0.058, 0.624)
const TARGET := Vector3(0.022, -0.012, -0.014)
const FOV := 0.5

var _effect := LumivoxEffect.new()
var _camera := Camera3D.new()
var _still := Transform3D()


func _ready() -> void:
	var size := get_viewport().get_visible_rect().size
	print("%s, Godot %s, %d x %d" % [RenderingServer.get_video_adapter_name(),
		Engine.get_version_info().string, size.x, size.y])
	RenderingServer.viewport_set_measure_render_time(get_viewport().get_viewport_rid(), true)
	var world := WorldEnvironment.new()
	world.environment = Environment.new()
	world.compositor = Compositor.new()
	_effect.environment_source = 1
	world.compositor.compositor_effects = [_effect]
	add_child(world)
	_camera.fov = rad_to_deg(FOV)
	_still = Transform3D(Basis.looking_at(TARGET - EYE), EYE)
	_camera.transform = _still
	add_child(_camera)
	var volume := LumivoxVolume3D.new()
	volume.volume = LumivoxVolume.phantom("head", 192)
	volume.apply_preset("ct-skin")

	print("%-36s %8s %8s %8s %8s" % ["frame, ms", "frame", "gpu", "tracing", "sample"])
	await _row("no volume", 8.0, 1, false)
	add_child(volume)
	# Until its kernels are made, which takes seconds where the driver does not know them yet.
	while Lumivox.get_status(get_viewport()).get("samples", 0) == 0 and Lumivox.last_error().is_empty():
		await RenderingServer.frame_post_draw
	await _row("still, budget 4 ms", 4.0, 1 << 20, false)
	await _row("still, budget 8 ms", 8.0, 1 << 20, false)
	await _row("still, budget 16 ms", 16.0, 1 << 20, false)
	await _row("moving, budget 8 ms", 8.0, 1 << 20, true)
	await _row("converged", 100.0, 1, false)
	if not Lumivox.last_error().is_empty():
		printerr(Lumivox.last_error())
	get_tree().quit()


func _row(what: String, budget: float, target: int, moving: bool) -> void:
	_effect.frame_budget_ms = budget
	_effect.target_samples = target
	var viewport := get_viewport()
	var pixels := viewport.get_visible_rect().get_area()
	var times: Array[float] = []
	var gpu: Array[float] = []
	var tracing: Array[float] = []
	var samples: Array[float] = []
	for frame in WARM_UP + FRAMES:
		_camera.transform = _still.translated(Vector3(frame * 1e-4 if moving else 0.0, 0.0, 0.0))
		var begin := Time.get_ticks_usec()
		await RenderingServer.frame_post_draw
		if frame < WARM_UP:
			continue
		times.append((Time.get_ticks_usec() - begin) * 1e-3)
		gpu.append(RenderingServer.viewport_get_measured_render_time_gpu(viewport.get_viewport_rid()))
		var status := Lumivox.get_status(viewport)
		if status.get("pixel_samples", 0) > 0:
			tracing.append(status.ms_per_frame)
			samples.append(status.ms_per_frame * pixels / status.pixel_samples)
	print("%-36s %8.2f %8.2f %8.2f %8.2f" % [what, _median(times), _median(gpu), _median(tracing), _median(samples)])


func _median(list: Array[float]) -> float:
	list.sort()
	return list[list.size() / 2] if not list.is_empty() else 0.0
