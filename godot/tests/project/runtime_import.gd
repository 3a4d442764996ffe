extends Node
## Imports scans in the running game while it draws a volume, and tells what came of each in lines `TELL name JSON`.

const Shower := preload("res://tests/show_cases.gd")
const PATIENCE_MS := 240_000

## What an importer has said, in order.
var heard: Array = []


func _ready() -> void:
	var arguments := Shower.arguments_by_name()
	var all: Dictionary = JSON.parse_string(FileAccess.get_file_as_string(arguments["cases"]))
	var viewport := LumivoxCase.viewport(all.case)
	add_child(viewport)
	for frame in 20:
		await get_tree().process_frame
	var node: LumivoxVolume3D = viewport.get_child(0).get_node("volumes0")
	for job: Dictionary in all.jobs:
		if job.zip != "":
			zip(job.zip, job.path)
		if job.copy != "":
			DirAccess.copy_absolute(job.copy, job.path)
		var told := await load_scan(job.path)
		if job.blocking:
			var begin := Time.get_ticks_usec()
			var volume := LumivoxVolume.load_file(job.path)
			told.blocking_ms = (Time.get_ticks_usec() - begin) / 1000.0
			told.blocking = describe(volume)
		print("TELL %s %s" % [job.name, JSON.stringify(told)])
		if job.name == "series":
			node.volume = told_volume
			if not await Shower.until_converged(viewport):
				push_error("what was imported is not shown")
	await cancelling(all.large)
	await scanning(all.series)
	await keeping(all.torso)
	await labelling(all.torso)
	await saving(all.mixed)
	await picturing(all.series, all.large)
	await panelling(all.series, all.large)
	await misuse(all.series)
	await by_name(node, all.series)
	get_tree().quit()


var told_volume: LumivoxVolume


func listened() -> LumivoxImporter:
	heard.clear()
	var importer := LumivoxImporter.new()
	importer.progress.connect(func(stage: String, done: int, total: int) -> void:
		heard.append(["progress", stage, done, total]))
	importer.finished.connect(func(volume: LumivoxVolume) -> void:
		told_volume = volume
		heard.append(["finished"]))
	importer.failed.connect(func(message: String) -> void: heard.append(["failed", message]))
	importer.cancelled.connect(func() -> void: heard.append(["cancelled"]))
	importer.labelled.connect(func(labels: LumivoxLabels) -> void: heard.append(["labelled", labels]))
	importer.scanned.connect(func(report: Dictionary) -> void: heard.append(["scanned", report]))
	importer.thumbnail_ready.connect(func(series: int, image: Image) -> void: heard.append(["picture", series, image]))
	return importer


## Frames until the importer has ended, the longest of them in ms, and all of it in ms.
func until_ended() -> Dictionary:
	var begin := Time.get_ticks_usec()
	var last := begin
	var longest := 0
	var frames := 0
	while heard.is_empty() or heard[-1][0] == "progress":
		await get_tree().process_frame
		var now := Time.get_ticks_usec()
		longest = maxi(longest, now - last)
		last = now
		frames += 1
		if now - begin > PATIENCE_MS * 1000:
			push_error("the import does not end")
			break
	return {"frames": frames, "longest_ms": longest / 1000.0, "ms": (last - begin) / 1000.0}


func load_scan(path: String) -> Dictionary:
	told_volume = null
	var importer := listened()
	var error := importer.start([path])
	var told := await until_ended()
	told.error = error
	told.heard = heard.duplicate()
	told.running = importer.is_running()
	told.volume = describe(told_volume)
	return told


static func describe(volume: LumivoxVolume) -> Variant:
	if volume == null:
		return null
	var dims := volume.get_dimensions()
	var spacing := volume.get_spacing_mm()
	var span := volume.get_value_range()
	var histogram := volume.get_histogram(64, span)
	var count := 0.0
	for bin in histogram:
		count += bin
	return {
		"dims": [dims.x, dims.y, dims.z], "spacing": [spacing.x, spacing.y, spacing.z],
		"range": [span.x, span.y], "unit": volume.get_unit(), "counted": count,
		"report": volume.get_report()}


static func zip(folder: String, to: String) -> void:
	var packer := ZIPPacker.new()
	packer.open(to)
	for file in DirAccess.get_files_at(folder):
		packer.start_file("study/" + file)
		packer.write_file(FileAccess.get_file_as_bytes(folder.path_join(file)))
		packer.close_file()
	packer.close()


## Cancelled when it first says how far it is; the same importer can start again.
func cancelling(path: String) -> void:
	var importer := listened()
	var cancel := func(_stage: String, _done: int, _total: int) -> void: importer.cancel()
	importer.progress.connect(cancel)
	importer.start([path])
	var busy := importer.start([path])
	await until_ended()
	importer.progress.disconnect(cancel)
	var after_cancel := heard.duplicate()
	heard.clear()
	importer.start([path])
	await until_ended()
	print("TELL cancelling ", JSON.stringify({"busy": busy, "cancelled": after_cancel, "again": heard}))
	# Dropped while it runs, it still ends, and nothing is left behind.
	listened().start([path])
	await until_ended()
	print("TELL dropped ", JSON.stringify(heard[-1]))


func scanning(path: String) -> void:
	var importer := listened()
	importer.scan([path])
	await until_ended()
	var scanned: Array = heard[-1]
	heard.clear()
	importer.start([path])
	await until_ended()
	print("TELL scanning ", JSON.stringify({"scanned": scanned, "started": heard[-1]}))


## What lies around the patient is there when it is asked for, whichever way a scan is loaded.
func keeping(path: String) -> void:
	var told := {}
	for options: Dictionary in [{}, {"keep_everything": true}]:
		var name := "everything" if options.get("keep_everything", false) else "patient"
		var importer := listened()
		importer.scan([path])
		await until_ended()
		heard.clear()
		importer.start([path], options)
		await until_ended()
		var stages := {}
		for one: Array in heard:
			if one[0] == "progress":
				stages[one[1]] = true
		told[name] = {"scanned": described_content(told_volume), "stages": stages.keys()}
		importer = listened()
		importer.start([path], options)
		await until_ended()
		told[name].started = described_content(told_volume)
		var waited := LumivoxVolume.load_file(path, options)
		told[name].waited = described_content(waited)
		var file := "user://kept.res"
		ResourceSaver.save(waited, file, ResourceSaver.FLAG_COMPRESS)
		var saved: LumivoxVolume = ResourceLoader.load(file, "", ResourceLoader.CACHE_MODE_IGNORE)
		told[name].aside = [waited.has_surroundings(), saved.has_surroundings()]
	print("EXPECT an error about an option that is neither true nor false")
	told.wrong = LumivoxVolume.load_file(path, {"keep_everything": "some"}) == null
	print("TELL keeping ", JSON.stringify(told))


## Labels that are found while the game goes on are those that one waits for; cancelled, there are none.
func labelling(path: String) -> void:
	var volume := LumivoxVolume.load_file(path)
	var importer := listened()
	var started := importer.find_labels(volume)
	var busy := importer.find_labels(volume)
	importer.cancel()
	await until_ended()
	var told := {"started": started, "busy": busy, "stopped": heard[-1], "returned": heard.size()}
	heard.clear()
	importer.find_labels(volume)
	var time := await until_ended()
	var found: LumivoxLabels = heard[-1][1]
	var waited := LumivoxLabels.found_in(volume)
	told.same = found.get("_stored").voxels == waited.get("_stored").voxels
	told.names = Array(found.get_names())
	told.frames = time.frames
	told.stages = heard.filter(func(one: Array) -> bool: return one[0] == "progress").map(func(one: Array) -> String:
		return one[1])
	heard.clear()
	importer.load_labels("user://nothing.nrrd")
	await until_ended()
	told.missing = heard[-1][0]
	print("EXPECT an error about a volume without a scan")
	told.nothing = [importer.find_labels(LumivoxVolume.new())]
	print("EXPECT an error about no path")
	told.nothing.append(importer.load_labels(""))
	print("TELL labelling ", JSON.stringify(told))


## Voxels that are denser than air, and the notes.
static func described_content(volume: LumivoxVolume) -> Dictionary:
	var counts := volume.get_histogram(1, Vector2(-700.0, 3000.0))
	return {"dense": counts[0], "notes": Array(volume.get_report().notes)}


## What of a scan's report is in a file of it, in what is loaded from that, and in what an older file held.
func saving(path: String) -> void:
	var volume := LumivoxVolume.load_file(path)
	var file := "user://saved.res"
	ResourceSaver.save(volume, file)
	var loaded: LumivoxVolume = ResourceLoader.load(file, "", ResourceLoader.CACHE_MODE_IGNORE)
	var older := LumivoxVolume.new()
	var stored: Dictionary = volume.get("_stored")
	stored["report"] = volume.get_report()
	stored.erase("source")
	older.set("_stored", stored)
	print("TELL saving ", JSON.stringify({
		"file": ProjectSettings.globalize_path(file), "session": volume.get_report(), "loaded": describe(loaded),
		"older": describe(older), "path": path,
		"sources": [volume, loaded, older].map(func(one: LumivoxVolume) -> PackedStringArray: return one.get_source_files())}))


## Pictures that are asked for do not come at once, and not if another is asked for or they are stopped.
func picturing(path: String, large: String) -> void:
	var importer := listened()
	var told := {"unknown": importer.request_thumbnail(0)}
	importer.scan([path])
	await until_ended()
	told.beyond = importer.request_thumbnail(1)
	var waited := importer.thumbnail(0, 16)
	heard.clear()
	told.requested = importer.request_thumbnail(0, 64)
	importer.request_thumbnail(0, 32)
	importer.cancel()
	importer.request_thumbnail(0, 16)
	told.at_once = heard.size()
	await until_ended()
	told.kinds = heard.map(func(one: Array) -> String: return one[0])
	var picture: Image = heard[-1][2]
	told.size = picture.get_width()
	told.same = picture.get_data() == waited.get_data()
	# An import does not wait for a picture, and nothing is heard of that.
	heard.clear()
	importer.request_thumbnail(0, 64)
	told.started = importer.start([path])
	await until_ended()
	told.imported = heard.filter(func(one: Array) -> bool: return one[0] != "progress").map(
			func(one: Array) -> String: return one[0])
	# Dropped while it makes one.
	var dropped := LumivoxImporter.new()
	dropped.scanned.connect(func(_report: Dictionary) -> void: dropped.request_thumbnail(0, 256), CONNECT_ONE_SHOT)
	dropped.scan([large])
	while dropped.is_running():
		await get_tree().process_frame
	dropped = null
	print("TELL picturing ", JSON.stringify(told))


## Scans that are opened in the panel one after the other, before those before are loaded.
func panelling(path: String, large: String) -> void:
	var panel: LumivoxVolumePanel = (load("res://addons/lumivox/ui/volume_panel.tscn") as PackedScene).instantiate()
	var node := LumivoxVolume3D.new()
	add_child(node)
	panel.volume_node = node
	add_child(panel)
	var importer := func() -> LumivoxImporter: return panel.get("_importer")
	var works := func() -> bool: return (panel.get("_work") as Control).visible
	var idle := func() -> bool: return not works.call()
	var told := {}
	panel.open([large])
	var first: LumivoxImporter = importer.call()
	panel.open([large])
	var second: LumivoxImporter = importer.call()
	# Said late: the second may be done before the first hears of its end.
	first.cancelled.emit()
	told.second = [second != first, importer.call() == second, works.call()]
	panel.cancel()
	await until(func() -> bool: return not second.is_running())
	told.stopped = [node.volume == null, importer.call() == null, works.call()]
	panel.open([large])
	panel.open([path])
	await until(idle)
	told.shown = node.volume != null and node.volume.get_dimensions() == Vector3i(24, 24, 24)
	# The panel turns to another node meanwhile.
	var other := LumivoxVolume3D.new()
	add_child(other)
	node.volume = null
	panel.open([path])
	panel.volume_node = other
	await until(idle)
	told.kept = node.volume != null and other.volume == null
	panel.open([path])
	other.free()
	await until(idle)
	told.gone = (panel.get("_message") as Label).text
	panel.free()
	node.free()
	print("TELL panelling ", JSON.stringify(told))


func until(condition: Callable) -> void:
	var begin := Time.get_ticks_msec()
	while not condition.call():
		if Time.get_ticks_msec() - begin > PATIENCE_MS:
			push_error("this does not come about")
			return
		await get_tree().process_frame


func misuse(path: String) -> void:
	var importer := listened()
	print("EXPECT an error about no paths at all")
	var nothing := importer.start([])
	print("EXPECT an error about null for a viewport")
	var status := Lumivox.get_status(null)
	print("EXPECT an error about an option that there is not")
	var option := importer.start([path], {"colour": "red"})
	importer.cancel()
	await get_tree().process_frame
	print("TELL misuse ", JSON.stringify({
		"nothing": nothing, "status": status, "option": option, "heard": heard}))


## What the README's C# does: members by name, through `ClassDB` and `Object`, as C# reaches them.
func by_name(node: VisualInstance3D, path: String) -> void:
	var readme := FileAccess.get_file_as_string("res://addons/lumivox/README.md")
	var sample := readme.get_slice("```csharp", 1).get_slice("```", 0)
	var said := RegEx.create_from_string("(Instantiate|GetSingleton|Connect|Set|Call)\\(\"(\\w+)\"")
	var importer: Object = ClassDB.instantiate("LumivoxImporter")
	var objects: Array[Object] = [node, importer, Engine.get_singleton("Lumivox")]
	var names := 0
	var unknown := []
	for found in said.search_all(sample):
		var called := found.get_string(2)
		var known := false
		match found.get_string(1):
			"Instantiate":
				known = ClassDB.can_instantiate(called)
			"GetSingleton":
				known = Engine.has_singleton(called)
			"Connect":
				known = importer.has_signal(called)
			"Set":
				known = called in node
			"Call":
				known = objects.any(func(object: Object) -> bool: return object.has_method(called))
		names += 1
		if not known:
			unknown.append(called)
	heard.clear()
	node.set("volume", null)
	importer.connect("finished", func(volume: Resource) -> void:
		node.set("volume", volume)
		node.call("apply_preset", "ct-bone")
		node.set("clip_max", Vector3(0.5, 1.0, 1.0))
		heard.append(["finished"]))
	importer.connect("failed", func(message: String) -> void: heard.append(["failed", message]))
	importer.call("start", PackedStringArray([path]))
	await until_ended()
	var converged: Variant = Engine.get_singleton("Lumivox").call("is_converged", node.get_viewport())
	print("TELL by_name ", JSON.stringify({
		"names": names, "unknown": unknown, "heard": heard, "converged": type_string(typeof(converged)),
		"volume": node.get("volume").get_class(), "clip_max": node.get("clip_max").x}))
