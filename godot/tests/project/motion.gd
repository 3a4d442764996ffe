extends Node
## Changes scenes while they are shown, and tells what their viewports show: pictures, and lines `TELL name JSON`.

const Shower := preload("res://tests/show_cases.gd")
const PATIENCE_MS := 240_000

var all: Dictionary
var out: String


func _ready() -> void:
	var arguments := Shower.arguments_by_name()
	all = JSON.parse_string(FileAccess.get_file_as_string(arguments["cases"]))
	out = arguments["out"]
	await edits()
	await effect_settings()
	await walks()
	await velocities()
	await animation()
	await scene_reload()
	await foreign_compositor()
	await two_cameras()
	await many_worlds()
	await kept_light()
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


func converge(viewport: Viewport, what: String) -> void:
	if not await Shower.until_converged(viewport):
		push_error("%s does not converge: %s" % [what, Lumivox.get_status(viewport)])


func save(viewport: Viewport, what: String) -> void:
	LumivoxCase.save(viewport, out.path_join(what))


## One change after another in a viewport that is not made anew: the next frame, and what it converges to.
func edits() -> void:
	var list: Array = all.edits
	# Else the frame after an edit that wants another kernel would still show the scene before.
	Lumivox.warm_up(["surface", "filters", "lights"])
	await Lumivox.warmed_up
	var viewport := show_case(list[0])
	await converge(viewport, "edits")
	save(viewport, list[0].name)
	var root := viewport.get_child(0)
	for i in range(1, len(list)):
		var case: Dictionary = list[i]
		LumivoxCase.change(root, list[i - 1], case)
		await RenderingServer.frame_post_draw
		var first := Lumivox.get_status(viewport)
		save(viewport, case.name + "_first")
		await converge(viewport, case.name)
		save(viewport, case.name)
		tell(case.name, {"first": first, "last": Lumivox.get_status(viewport)})
	await close(viewport)


## What is shown changes, what was traced stays.
func effect_settings() -> void:
	var list: Array = all.settings
	var viewport := show_case(list[0])
	await converge(viewport, "settings")
	for i in range(1, len(list)):
		var case: Dictionary = list[i]
		LumivoxCase.change(viewport.get_child(0), list[i - 1], case)
		var least := 1 << 30
		var frames := 0
		while frames < 2 or not Lumivox.is_converged(viewport):
			await RenderingServer.frame_post_draw
			least = mini(least, Lumivox.get_status(viewport).get("samples", 0))
			frames += 1
		await RenderingServer.frame_post_draw
		save(viewport, case.name)
		tell(case.name, {"least": least, "frames": frames, "last": Lumivox.get_status(viewport)})
	await close(viewport)


## Something moves in every frame, and every frame is kept.
func walks() -> void:
	for walk: String in all.walks:
		var list: Array = all.walks[walk]
		var viewport := show_case(list[0])
		await converge(viewport, walk)
		for i in range(1, len(list)):
			LumivoxCase.change(viewport.get_child(0), list[i - 1], list[i])
			await RenderingServer.frame_post_draw
			save(viewport, list[i].name)
		await converge(viewport, walk)
		save(viewport, walk)
		await close(viewport)


## Reads what the engine keeps of motion, once volumes are drawn.
class Velocities extends CompositorEffect:
	const READ := """#version 450
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform sampler2D velocities;
layout(set = 0, binding = 1, std430) restrict writeonly buffer Told { vec2 told[]; };
void main() {
	ivec2 size = textureSize(velocities, 0);
	ivec2 at = ivec2(gl_GlobalInvocationID.xy);
	if (all(lessThan(at, size))) {
		told[at.y * size.x + at.x] = texelFetch(velocities, at, 0).xy;
	}
}
"""
	var told := PackedFloat32Array()

	func _init() -> void:
		effect_callback_type = EFFECT_CALLBACK_TYPE_POST_TRANSPARENT

	func _render_callback(_kind: int, data: RenderData) -> void:
		var device := RenderingServer.get_rendering_device()
		var buffers: RenderSceneBuffersRD = data.get_render_scene_buffers()
		var size := buffers.get_internal_size()
		var source := RDShaderSource.new()
		source.source_compute = READ
		var shader := device.shader_create_from_spirv(device.shader_compile_spirv_from_source(source))
		var pipeline := device.compute_pipeline_create(shader)
		var written := device.storage_buffer_create(size.x * size.y * 8)
		var sampler := device.sampler_create(RDSamplerState.new())
		var read := RDUniform.new()
		read.uniform_type = RenderingDevice.UNIFORM_TYPE_SAMPLER_WITH_TEXTURE
		read.add_id(sampler)
		read.add_id(buffers.get_velocity_texture())
		var write := RDUniform.new()
		write.uniform_type = RenderingDevice.UNIFORM_TYPE_STORAGE_BUFFER
		write.binding = 1
		write.add_id(written)
		var bound := device.uniform_set_create([read, write], shader, 0)
		var list := device.compute_list_begin()
		device.compute_list_bind_compute_pipeline(list, pipeline)
		device.compute_list_bind_uniform_set(list, bound, 0)
		device.compute_list_dispatch(list, ceili(size.x / 8.0), ceili(size.y / 8.0), 1)
		device.compute_list_end()
		told = device.buffer_get_data(written).to_float32_array()
		for id: RID in [bound, pipeline, shader, written, sampler]:
			device.free_rid(id)


## How far a volume that moves under temporal antialiasing has come, as the engine hears of it.
func velocities() -> void:
	var viewport := show_case(all.smoothed[0])
	await converge(viewport, "smoothed")
	var world: WorldEnvironment = viewport.get_child(0).get_node("World")
	var reader := Velocities.new()
	var effects := world.compositor.compositor_effects
	effects.append(reader)
	world.compositor.compositor_effects = effects
	for frame in 2:
		await RenderingServer.frame_post_draw
	LumivoxCase.change(viewport.get_child(0), all.smoothed[0], all.smoothed[1])
	await RenderingServer.frame_post_draw
	tell("velocities", Array(reader.told))
	await close(viewport)


## A volume that an animation moves with its parent.
func animation() -> void:
	var case: Dictionary = all.animation
	var viewport := show_case(case)
	var root := viewport.get_child(0)
	await converge(viewport, "animation")
	save(viewport, "animation_begin")
	var parent := Node3D.new()
	parent.name = "Parent"
	root.add_child(parent)
	root.get_node("volumes0").reparent(parent)
	var move := Animation.new()
	move.length = 0.5
	move.add_track(Animation.TYPE_POSITION_3D)
	move.track_set_path(0, "Parent")
	var to: Vector3 = LumivoxCase.vector(all.animation_to)
	move.position_track_insert_key(0, 0.0, Vector3.ZERO)
	move.position_track_insert_key(0, move.length, to)
	var library := AnimationLibrary.new()
	library.add_animation("move", move)
	var player := AnimationPlayer.new()
	root.add_child(player)
	player.add_animation_library("", library)
	player.play("move")
	var positions := []
	while player.is_playing() and len(positions) < 100:
		await RenderingServer.frame_post_draw
		save(viewport, "animation_%d" % len(positions))
		positions.append([parent.position.x, parent.position.y, parent.position.z])
	tell("animation", positions)
	parent.position = to
	await converge(viewport, "animation")
	save(viewport, "animation_end")
	await close(viewport)


## The scene is freed under its viewport, and comes back.
func scene_reload() -> void:
	var case: Dictionary = all.reload
	var viewport := show_case(case)
	await converge(viewport, "reload")
	viewport.get_child(0).queue_free()
	for frame in 3:
		await RenderingServer.frame_post_draw
	tell("reload_empty", {
		"status": Lumivox.get_status(viewport), "converged": Lumivox.is_converged(viewport)})
	viewport.add_child(LumivoxCase.build(case))
	await RenderingServer.frame_post_draw
	await converge(viewport, "reload")
	save(viewport, "reload")
	# Only the volume goes, and comes back to the same place in the tree.
	var root := viewport.get_child(0)
	var volume := root.get_node("volumes0")
	root.remove_child(volume)
	for frame in 2:
		await RenderingServer.frame_post_draw
	save(viewport, "reload_without")
	root.add_child(volume)
	await converge(viewport, "reload")
	save(viewport, "reload_again")
	await close(viewport)


## A compositor without a LumivoxEffect: its owner sets the list of effects, and volumes stay.
func foreign_compositor() -> void:
	var viewport := show_case(all.compositor)
	var world: WorldEnvironment = viewport.get_child(0).get_node("World")
	var volume: LumivoxVolume3D = viewport.get_child(0).get_node("volumes0")
	var settings: LumivoxEffect = world.compositor.compositor_effects[0]
	var compositor := Compositor.new()
	var one := CompositorEffect.new()
	var told := {}
	var picture := func() -> PackedByteArray:
		# A few frames of an image that never rests.
		for frame in 3:
			await RenderingServer.frame_post_draw
		return viewport.get_texture().get_image().get_data()
	volume.hide()
	var empty: PackedByteArray = await picture.call()
	volume.show()
	world.compositor = compositor
	var lists := {
		"none": [], "one": [one], "the same": [one], "another": [one, CompositorEffect.new()], "an empty entry": [one, null],
		"its own": [settings], "none again": [],
	}
	for what: String in lists:
		var effects: Array[CompositorEffect] = []
		effects.assign(lists[what] as Array)
		compositor.compositor_effects = effects
		told[what] = await picture.call() != empty
	volume.hide()
	told["hidden"] = await picture.call() != empty
	tell("compositor", told)
	await close(viewport)


## Two viewports on one world: one's camera moves, the other goes on converging.
func two_cameras() -> void:
	var still: Dictionary = all.still_camera
	var moving: Array = all.moving_camera
	var first := show_case(still)
	var second := LumivoxCase.empty_viewport(moving[0])
	second.world_3d = first.find_world_3d()
	var camera := LumivoxCase.camera(moving[0])
	second.add_child(camera)
	add_child(second)
	await converge(first, "still_camera")
	await converge(second, "moving_camera")
	var stays := true
	var restarts := 0
	for case: Dictionary in moving:
		camera.transform = LumivoxCase.transform(case.camera)
		await RenderingServer.frame_post_draw
		stays = stays and Lumivox.is_converged(first)
		restarts += int(not Lumivox.is_converged(second))
	tell("two_cameras", {"stays": stays, "restarts": restarts, "moves": len(moving)})
	save(first, "still_camera")
	await converge(second, "moving_camera")
	save(second, "moving_camera")
	await close(second)
	await close(first)


## Viewports side by side, each with a world of its own, all at once; then some go.
func many_worlds() -> void:
	var viewports: Array[SubViewport] = []
	for case: Dictionary in all.worlds:
		viewports.append(show_case(case))
	for i in len(viewports):
		await converge(viewports[i], all.worlds[i].name)
	for i in range(0, len(viewports), 2):
		await close(viewports[i])
	for frame in 3:
		await RenderingServer.frame_post_draw
	for i in range(1, len(viewports), 2):
		save(viewports[i], all.worlds[i].name)
		tell(all.worlds[i].name, Lumivox.get_status(viewports[i]))
	for i in range(1, len(viewports), 2):
		await close(viewports[i])
	for case: Dictionary in all.worlds:
		var viewport := show_case(case)
		await converge(viewport, case.name)
		save(viewport, case.name + "_anew")
		await close(viewport)


## A camera that moves with every frame, with light that is kept in the volumes and without: its last frame.
func kept_light() -> void:
	var list: Array = all.kept_light
	var told := {}
	for keeps: bool in [true, false]:
		var viewport := show_case(list[0])
		var root := viewport.get_child(0)
		var effect: LumivoxEffect = root.get_node("World").compositor.compositor_effects[0]
		told["default"] = LumivoxEffect.new().kept_light
		effect.kept_light = keeps
		# Its kernels may still be made, and nothing waits for them.
		var begin := Time.get_ticks_msec()
		var frame := 0
		while Time.get_ticks_msec() - begin < PATIENCE_MS:
			frame += 1
			LumivoxCase.change(root, list[frame % 2], list[1 - frame % 2])
			await RenderingServer.frame_post_draw
			var status := Lumivox.get_status(viewport)
			if not status.is_empty() and (not keeps or status.kept_light_bytes > 0):
				break
		for i in range(2, len(list)):
			LumivoxCase.change(root, list[i - 1], list[i])
			await RenderingServer.frame_post_draw
		var what := "kept" if keeps else "plain"
		save(viewport, "kept_light_%s" % what)
		told[what] = Lumivox.get_status(viewport).kept_light_bytes
		await close(viewport)
	tell("kept_light", told)
