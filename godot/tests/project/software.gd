extends Node
## Tells what the demo's main scene does on the adapter it runs on.


func _ready() -> void:
	var scene := (load("res://main.tscn") as PackedScene).instantiate()
	(scene.get_node("PhantomSource") as PhantomSource).size = 32
	add_child(scene)
	var world := scene.get_node("WorldEnvironment") as WorldEnvironment
	var effect := world.compositor.compositor_effects[0] as LumivoxEffect
	await get_tree().process_frame
	print("TELL software %s" % JSON.stringify({
		"cpu": RenderingServer.get_video_adapter_type() == RenderingDevice.DEVICE_TYPE_CPU,
		"budget_ms": effect.frame_budget_ms,
		"ssao": world.environment.ssao_enabled,
	}))
	get_tree().quit()
