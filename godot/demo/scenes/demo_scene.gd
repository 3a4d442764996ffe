extends Node3D
## A scene of the demo: when the phantom is there the panel shows it, and the camera frames it if asked to.

const Screenshot := preload("res://scenes/demo_screenshot.gd")

## Milliseconds for tracing in a frame that is drawn in software: it takes a quarter of a second as it is, and with the
## few that a GPU needs no sample would come of it.
const SOFTWARE_BUDGET_MS := 150.0

## What is waited for.
@export var source: PhantomSource
## Shows the volume that was grown.
@export var panel: LumivoxVolumePanel
## Frames a scan that was opened in place of the phantom.
@export var camera: LumivoxOrbitCamera


func _ready() -> void:
	source.grown.connect(_on_grown)
	if RenderingServer.get_video_adapter_type() == RenderingDevice.DEVICE_TYPE_CPU:
		_lighten()
	var screenshot := Screenshot.from_command_line()
	if screenshot != null:
		source.grown.connect(func(_volume: LumivoxVolume) -> void:
			_hold_still()
			add_child(screenshot))
	if panel != null and camera != null:
		panel.volume_opened.connect(_on_opened)


func _on_grown(_volume: LumivoxVolume) -> void:
	if panel != null:
		panel.refresh()


## Leaves out what takes a processor long, and gives the time to the volumes.
func _lighten() -> void:
	for world: WorldEnvironment in find_children("*", "WorldEnvironment"):
		world.environment.ssao_enabled = false
		world.environment.glow_enabled = false
		for effect in world.compositor.compositor_effects:
			if effect is LumivoxEffect:
				(effect as LumivoxEffect).frame_budget_ms = SOFTWARE_BUDGET_MS
	RenderingServer.directional_soft_shadow_filter_set_quality(RenderingServer.SHADOW_QUALITY_SOFT_MEDIUM)
	RenderingServer.positional_soft_shadow_filter_set_quality(RenderingServer.SHADOW_QUALITY_SOFT_MEDIUM)


## Stops what moves, where a picture of it says the most.
func _hold_still() -> void:
	pass


func _on_opened(_volume: LumivoxVolume) -> void:
	camera.frame_target()
