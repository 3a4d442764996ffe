@tool
extends Node
## Computes the head phantom in the background and saves it into the project, for those who have no scan at hand.

## Emitted with the phantom, or with null if it could not be saved.
signal done(volume: LumivoxVolume)

const PATH := "res://head_phantom.res"
const SIZE := 128

var _task := -1
var _volume: LumivoxVolume


func _ready() -> void:
	_task = WorkerThreadPool.add_task(_work, false, "Lumivox phantom")


func _process(_delta: float) -> void:
	if _task < 0 or not WorkerThreadPool.is_task_completed(_task):
		return
	WorkerThreadPool.wait_for_task_completion(_task)
	_task = -1
	if _volume != null:
		_volume.take_over_path(PATH)
		EditorInterface.get_resource_filesystem().scan()
	done.emit(_volume)
	queue_free()


func _exit_tree() -> void:
	if _task >= 0:
		WorkerThreadPool.wait_for_task_completion(_task)
		_task = -1


func _work() -> void:
	var volume := LumivoxVolume.phantom("head", SIZE)
	volume.resource_name = "Head phantom"
	var error := ResourceSaver.save(volume, PATH, ResourceSaver.FLAG_COMPRESS)
	if error == OK:
		_volume = volume
	else:
		push_error("Lumivox: %s could not be written: %s." % [PATH, error_string(error)])
