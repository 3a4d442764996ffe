extends Node
## What a LumivoxEffect says, and the compositors it is in or not, while volumes are shown: pictures, and lines
## `TELL name JSON`.

const Shower := preload("res://tests/show_cases.gd")

## Frames after which an image of these cases has converged, if it ever does.
const PATIENCE_FRAMES := 400

var all: Dictionary
var out: String


## An effect that somebody else wrote.
class Counter extends CompositorEffect:
	var calls := 0

	func _render_callback(_kind: int, _data: RenderData) -> void:
		calls += 1


func _ready() -> void:
	var arguments := Shower.arguments_by_name()
	all = JSON.parse_string(FileAccess.get_file_as_string(arguments["cases"]))
	out = arguments["out"]
	limits()
	constants()
	await hide_and_show()
	await hide_and_show_beside_another()
	await two_effects()
	await disabled()
	await freed_nodes()
	await redraws()
	await moved_mesh()
	await exposures()
	get_tree().quit()


static func tell(what: String, told: Variant) -> void:
	print("TELL %s %s" % [what, JSON.stringify(told)])


func show_case(case: Dictionary) -> SubViewport:
	var viewport := LumivoxCase.viewport(case)
	add_child(viewport)
	return viewport


func close(viewport: SubViewport) -> void:
	viewport.queue_free()
	await get_tree().process_frame


func frames(count: int) -> void:
	for frame in count:
		await RenderingServer.frame_post_draw


func converge(viewport: Viewport) -> bool:
	for frame in PATIENCE_FRAMES:
		await RenderingServer.frame_post_draw
		var status := Lumivox.get_status(viewport)
		if frame > 3 and status.get("converged", false):
			await RenderingServer.frame_post_draw
			return true
	return false


func save(viewport: Viewport, what: String) -> void:
	LumivoxCase.save(viewport, out.path_join(what))


func pixels(viewport: Viewport) -> PackedByteArray:
	return viewport.get_texture().get_image().get_data()


func world_of(viewport: Viewport) -> WorldEnvironment:
	return viewport.get_child(0).get_node("World")


func volume_of(viewport: Viewport) -> LumivoxVolume3D:
	return viewport.get_child(0).get_node("volumes0")


static func give(compositor: Compositor, list: Array) -> void:
	var effects: Array[CompositorEffect] = []
	effects.assign(list)
	compositor.compositor_effects = effects


## What a setter makes of values beyond its range, and of those that are none.
func limits() -> void:
	var told := {}
	var tries := {
		"exposure": [100.0, -100.0, 3.5], "target_samples": [0, 1 << 20, 77], "frame_budget_ms": [0.0, 1e9, 5.0],
		"target_noise": [-1.0, 7.0, 0.25],
		"resolution_scale": [0.0, 7.0, 0.25], "environment_source": [-3, 9, 0],
	}
	var effect := LumivoxEffect.new()
	for property: String in tries:
		var kept := []
		for value: Variant in tries[property]:
			effect.set(property, value)
			kept.append(effect.get(property))
		told[property] = kept
	for property: String in ["exposure", "target_noise", "frame_budget_ms", "resolution_scale"]:
		var before: float = effect.get(property)
		var stays := true
		for value: float in [NAN, INF, -INF]:
			print("EXPECT an error of ", property)
			effect.set(property, value)
			stays = stays and effect.get(property) == before
		told[property + " stays"] = stays
	tell("limits", told)


func constants() -> void:
	var told := {"constants": {}, "units": {}}
	for constant in ClassDB.class_get_integer_constant_list("LumivoxEffect", true):
		told.constants[constant] = ClassDB.class_get_integer_constant("LumivoxEffect", constant)
	for property in ClassDB.class_get_property_list("LumivoxEffect", true):
		for part in (property.hint_string as String).split(","):
			if part.begins_with("suffix:"):
				told.units[property.name] = part.trim_prefix("suffix:")
	tell("constants", told)


## A volume that was drawn before its scene had a compositor is hidden and shown again.
func hide_and_show() -> void:
	var viewport := show_case(all.soft)
	var world := world_of(viewport)
	var compositor := world.compositor
	var counter := Counter.new()
	give(compositor, [counter, compositor.compositor_effects[0]])
	world.compositor = null
	await frames(3)
	world.compositor = compositor
	var converges := await converge(viewport)
	volume_of(viewport).hide()
	await frames(10)
	var calls := counter.calls
	await frames(3)
	var called := counter.calls > calls
	volume_of(viewport).show()
	var again := await converge(viewport)
	save(viewport, "shown_again")
	tell("hide_and_show", {"converges": converges, "others are called": called, "again": again})
	await close(viewport)


## The same with a compositor that has no LumivoxEffect, and then with none at all.
func hide_and_show_beside_another() -> void:
	var viewport := show_case(all.soft)
	var world := world_of(viewport)
	var counter := Counter.new()
	var compositor := Compositor.new()
	give(compositor, [counter])
	world.compositor = null
	await frames(3)
	world.compositor = compositor
	await frames(3)
	volume_of(viewport).hide()
	await frames(10)
	var calls := counter.calls
	var empty := pixels(viewport)
	await frames(3)
	var told := {"others are called": counter.calls > calls}
	volume_of(viewport).show()
	await frames(3)
	told["again"] = pixels(viewport) != empty
	world.compositor = null
	await frames(3)
	told["without"] = pixels(viewport) != empty
	calls = counter.calls
	await frames(3)
	told["others are gone"] = counter.calls == calls
	volume_of(viewport).hide()
	await frames(3)
	told["hidden"] = pixels(viewport) == empty
	# Both at once: no frame sees the one without the other.
	volume_of(viewport).show()
	await frames(3)
	volume_of(viewport).hide()
	world.compositor = compositor
	await frames(3)
	calls = counter.calls
	await frames(3)
	told["others are called again"] = counter.calls > calls
	tell("hide_and_show_beside_another", told)
	await close(viewport)


func two_effects() -> void:
	var viewport := show_case(all.soft)
	var compositor := world_of(viewport).compositor
	var first: LumivoxEffect = compositor.compositor_effects[0]
	var second := LumivoxEffect.new()
	second.target_samples = first.target_samples
	give(compositor, [first, second])
	await converge(viewport)
	save(viewport, "two_effects")
	var off := LumivoxEffect.new()
	off.exposure = 5.0
	off.enabled = false
	give(compositor, [off, first, second])
	await converge(viewport)
	await frames(3)
	save(viewport, "after_a_disabled_one")
	# Each effect is the first somewhere.
	var other := show_case(all.soft)
	give(world_of(other).compositor, [second, first])
	await converge(other)
	await frames(3)
	save(viewport, "effects_shared")
	save(other, "effects_shared_too")
	await close(other)
	# The engine names the effect itself again.
	give(compositor, [first])
	first.effect_callback_type = CompositorEffect.EFFECT_CALLBACK_TYPE_POST_TRANSPARENT
	await frames(3)
	save(viewport, "at_another_stage")
	await close(viewport)


func disabled() -> void:
	var viewport := show_case(all.soft)
	var effect: LumivoxEffect = world_of(viewport).compositor.compositor_effects[0]
	var told := {}
	var ask := func() -> Dictionary:
		await frames(6)
		return {"status": Lumivox.get_status(viewport), "converged": Lumivox.is_converged(viewport)}
	effect.enabled = false
	told["from the start"] = await ask.call()
	var empty := pixels(viewport)
	effect.enabled = true
	told["enabled"] = await converge(viewport)
	effect.enabled = false
	told["later"] = await ask.call()
	told["empty"] = pixels(viewport) == empty
	effect.enabled = true
	told["again"] = await converge(viewport)
	save(viewport, "enabled_again")
	tell("disabled", told)
	await close(viewport)


## Nodes that volumes are gathered with go at once, in the midst of a frame.
func freed_nodes() -> void:
	var viewport := show_case(all.lit)
	var second := LumivoxCase.empty_viewport(all.lit)
	second.world_3d = viewport.find_world_3d()
	var camera := LumivoxCase.camera(all.lit)
	second.add_child(camera)
	var other := WorldEnvironment.new()
	other.compositor = Compositor.new()
	second.add_child(other)
	add_child(second)
	var volume := LumivoxVolume3D.new()
	volume.volume = volume_of(viewport).volume
	viewport.get_child(0).add_child(volume)
	give(world_of(viewport).compositor, world_of(viewport).compositor.compositor_effects + [null])
	await frames(4)
	volume.free()
	viewport.get_child(0).get_node("lamps0").free()
	camera.free()
	await frames(2)
	other.free()
	second.free()
	await converge(viewport)
	save(viewport, "after_freed_nodes")
	await close(viewport)


## Whether an engine that idles draws the frame that a setting needs.
func redraws() -> void:
	var viewport := show_case(all.soft)
	var effect: LumivoxEffect = world_of(viewport).compositor.compositor_effects[0]
	await converge(viewport)
	OS.low_processor_usage_mode = true
	var told := {}
	var changes := {
		"exposure": 1.0, "target_samples": 12, "frame_budget_ms": 40.0, "resolution_scale": 0.5, "write_depth": false,
		"denoise": true, "kept_light": not effect.kept_light, "environment_source": 1, "target_noise": 0.2,
	}
	for property: String in changes:
		var idle := await until_idle()
		var before := Engine.get_frames_drawn()
		effect.set(property, changes[property])
		for frame in 5:
			await get_tree().process_frame
		told[property] = {"idle": idle, "frames": Engine.get_frames_drawn() - before}
	OS.low_processor_usage_mode = false
	tell("redraws", told)
	await close(viewport)


## A mesh moves once over a finished image of an engine that idles.
func moved_mesh() -> void:
	var viewport := show_case(all.mesh)
	await converge(viewport)
	OS.low_processor_usage_mode = true
	var told := {"idle": await until_idle()}
	LumivoxCase.change(viewport.get_child(0), all.mesh, all.moved_mesh)
	told["rests again"] = await until_idle()
	told["converged"] = Lumivox.is_converged(viewport)
	save(viewport, "moved_mesh")
	OS.low_processor_usage_mode = false
	tell("moved_mesh", told)
	await close(viewport)


## Two cameras look at one world, each with an exposure of its own.
func exposures() -> void:
	var first := show_case(all.solid)
	var second := LumivoxCase.empty_viewport(all.solid)
	second.world_3d = first.find_world_3d()
	var camera := LumivoxCase.camera(all.solid)
	second.add_child(camera)
	var multipliers := {first.get_camera_3d(): 0.5, camera: 3.0}
	for exposed: Camera3D in multipliers:
		exposed.attributes = CameraAttributesPractical.new()
		exposed.attributes.exposure_multiplier = multipliers[exposed]
	add_child(second)
	tell("exposures", {"first": await converge(first), "second": await converge(second)})
	save(first, "exposed_little")
	save(second, "exposed_much")
	await close(second)
	await close(first)


func until_idle() -> bool:
	var quiet := 0
	for frame in 1000:
		var drawn := Engine.get_frames_drawn()
		await get_tree().process_frame
		quiet = quiet + 1 if Engine.get_frames_drawn() == drawn else 0
		if quiet == 8:
			return true
	return false
