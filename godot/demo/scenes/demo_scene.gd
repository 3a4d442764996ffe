extends Node3D
## A scene of the demo: when the phantom is there the panel shows it, and the camera frames it if asked to.

const Screenshot := preload("res://scenes/demo_screenshot.gd")

## What is waited for.
@export var source: PhantomSource
## Shows the volume that was grown.
@export var panel: LumivoxVolumePanel
## Frames a scan that was opened in place of the phantom.
@export var camera: LumivoxOrbitCamera


func _ready() -> void:
	source.grown.connect(_on_grown)
	if RenderingServer.get_video_adapter_type() == RenderingDevice.DEVICE_TYPE_CPU:
		# In software Tricubic takes many times as long.
		for volume in source.targets:
			volume.filter = LumivoxVolume3D.FILTER_TRILINEAR
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


## Stops what moves, where a picture of it says the most.
func _hold_still() -> void:
	pass


func _on_opened(_volume: LumivoxVolume) -> void:
	camera.frame_target()
