@tool
class_name PhantomSource
extends Node
## Grows the head phantom in the background and gives it to volumes, in the editor and in the game.
##
## It is computed whenever it is needed and never saved: scenes stay small.

## Emitted when the volumes have it.
signal grown(volume: LumivoxVolume)

static var _known: Dictionary[int, LumivoxVolume] = {}

## Voxels along a side.
@export_range(32, 512) var size := 192
## The nodes that get the phantom.
@export var targets: Array[LumivoxVolume3D] = []
## The look of those that have none yet.
@export var preset := "ct-muscle"

var _task := -1
var _volume: LumivoxVolume


func _ready() -> void:
	if _known.has(size):
		_volume = _known[size]
		_deliver.call_deferred()
	else:
		_task = WorkerThreadPool.add_task(_grow, false, "Head phantom")


func _process(_delta: float) -> void:
	if _task >= 0 and WorkerThreadPool.is_task_completed(_task):
		WorkerThreadPool.wait_for_task_completion(_task)
		_task = -1
		_deliver()


func _exit_tree() -> void:
	if _task >= 0:
		WorkerThreadPool.wait_for_task_completion(_task)
		_task = -1


func _notification(what: int) -> void:
	# The editor must not write the voxels into the scene.
	if what == NOTIFICATION_EDITOR_PRE_SAVE:
		_show(null)
	elif what == NOTIFICATION_EDITOR_POST_SAVE:
		_show(_volume)


func _grow() -> void:
	_volume = LumivoxVolume.phantom("head", size)


func _deliver() -> void:
	if _volume == null:
		push_error("The phantom could not be made.")
		return
	_volume.resource_name = "Head phantom"
	_known[size] = _volume
	_show(_volume)
	for target in targets:
		if preset != "" and target.transfer_function == null:
			target.apply_preset(preset)
	grown.emit(_volume)


func _show(volume: LumivoxVolume) -> void:
	for target in targets:
		# Another scan that somebody chose stays.
		if target.volume == null or target.volume == _volume:
			target.volume = volume
