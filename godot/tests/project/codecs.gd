extends Node
## Imports a series and tells how often each multiple of ten is in it.

const Shower := preload("res://tests/show_cases.gd")


func _ready() -> void:
	var job: Dictionary = JSON.parse_string(FileAccess.get_file_as_string(Shower.arguments_by_name()["cases"]))
	print("TELL imported ", JSON.stringify(await import(job.path), "", true, true))
	get_tree().quit()


static func import(path: String) -> Dictionary:
	var importer := LumivoxImporter.new()
	var told := {}
	importer.failed.connect(func(message: String) -> void: told.failed = message)
	importer.finished.connect(func(volume: LumivoxVolume) -> void:
		told.report = volume.get_report()
		told.histogram = Array(volume.get_histogram(6, Vector2(-5.0, 55.0))))
	importer.start([path])
	while told.is_empty():
		await (Engine.get_main_loop() as SceneTree).process_frame
	return told
