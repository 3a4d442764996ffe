@tool
extends Node
## Finds the parts of a scan in the background and saves them beside it.

## Emitted with the labels, or with null where there are none: it was cancelled, or failed.
signal done(labels: LumivoxLabels)
## How far it is, 0 to 1.
signal progressed(part: float)

var _importer := LumivoxImporter.new()
var _path := ""
var _labels: LumivoxLabels
var _saving := -1


## Begins; returns whether it could.
func start(volume: LumivoxVolume) -> bool:
	_path = path_for(volume)
	_importer.progress.connect(func(_stage: String, part: int, total: int) -> void:
		progressed.emit(float(part) / maxi(total, 1)))
	_importer.labelled.connect(_save)
	_importer.cancelled.connect(_end.bind(null))
	_importer.failed.connect(func(message: String) -> void:
		push_error("Lumivox: %s" % message)
		_end(null))
	return _importer.find_labels(volume) == OK


## Stops it; [signal done] follows.
func cancel() -> void:
	_importer.cancel()


## Where labels of a scan are saved: beside it, or in the project's folder where it has no file of its own.
static func path_for(volume: LumivoxVolume) -> String:
	var scan := volume.resource_path
	if scan == "" or scan.contains("::"):
		scan = "res://scan"
	return scan.get_basename() + "_labels.res"


func _save(labels: LumivoxLabels) -> void:
	for note in labels.get_notes():
		print("Lumivox: %s" % note)
	_labels = labels
	_saving = WorkerThreadPool.add_task(_write, false, "Lumivox labels")


func _write() -> void:
	var error := ResourceSaver.save(_labels, _path, ResourceSaver.FLAG_COMPRESS)
	if error != OK:
		push_error("Lumivox: %s could not be written: %s." % [_path, error_string(error)])


func _process(_delta: float) -> void:
	if _saving < 0 or not WorkerThreadPool.is_task_completed(_saving):
		return
	WorkerThreadPool.wait_for_task_completion(_saving)
	_saving = -1
	if FileAccess.file_exists(_path):
		_labels.take_over_path(_path)
		EditorInterface.get_resource_filesystem().scan()
	_end(_labels)


func _end(labels: LumivoxLabels) -> void:
	done.emit(labels)
	queue_free()


func _exit_tree() -> void:
	_importer.cancel()
	if _saving >= 0:
		WorkerThreadPool.wait_for_task_completion(_saving)
		_saving = -1
