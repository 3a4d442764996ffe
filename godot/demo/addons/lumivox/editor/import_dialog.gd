@tool
extends ConfirmationDialog
## 'Import a Scan': choose a folder, archive or file, see what it holds, choose a series, and save it into the project.
##
## Reading and saving go on in the background; the editor stays usable.

enum Step { CHOOSE, SCANNING, READY, IMPORTING, SAVING }

const ArrayFields := preload("array_fields.gd")
const VolumeInspector := preload("volume_inspector.gd")

const COLUMNS: PackedStringArray = ["Series", "What it is", "Voxels", "Phases", "Files", "Remark"]
const COLUMN_RATIOS: PackedInt32Array = [2, 10, 5, 2, 2, 4]
const THUMBNAIL_SIZE := 160

var _undo: EditorUndoRedoManager
## The node that the scan is for, or null. Another one must wait while something is under way.
var _receiver: LumivoxVolume3D
var _importer: LumivoxImporter
var _step := Step.CHOOSE
var _report: Dictionary = {}
var _save_task := -1
var _save_result := OK
var _volume: LumivoxVolume
## Where the scan that is imported will be saved, whatever the fields say meanwhile.
var _saved_as := ""
## The path that was proposed last, until the user writes another.
var _suggested := ""

var _path := LineEdit.new()
var _raw := LineEdit.new()
var _array := ArrayFields.new()
var _allow_outside := CheckBox.new()
var _browse := MenuButton.new()
var _series := Tree.new()
var _details := RichTextLabel.new()
var _thumbnail := TextureRect.new()
var _phase_row := HBoxContainer.new()
var _phase := SpinBox.new()
var _target := LineEdit.new()
var _keep_everything := CheckBox.new()
var _add_to_scene := CheckBox.new()
var _stage := Label.new()
var _progress := ProgressBar.new()
var _stop := Button.new()
var _files: FileDialog


func _init(undo: EditorUndoRedoManager = null) -> void:
	_undo = undo
	title = "Import a Scan"
	ok_button_text = "Import"
	dialog_hide_on_ok = false
	exclusive = false
	var column := VBoxContainer.new()
	add_child(column)
	column.add_child(_source_row())
	column.add_child(_raw_row())
	column.add_child(_array)
	column.add_child(_outside_row())
	column.add_child(_series_tree())
	column.add_child(_details_row())
	column.add_child(_target_row())
	column.add_child(_progress_row())
	_array.submitted.connect(_scan)
	confirmed.connect(_on_confirmed)
	canceled.connect(_stop_work)
	close_requested.connect(_stop_work)
	set_process(false)


func _process(_delta: float) -> void:
	if _save_task >= 0 and WorkerThreadPool.is_task_completed(_save_task):
		WorkerThreadPool.wait_for_task_completion(_save_task)
		_save_task = -1
		set_process(false)
		_on_saved()


func _exit_tree() -> void:
	if _importer != null:
		_importer.cancel()
	if _save_task >= 0:
		WorkerThreadPool.wait_for_task_completion(_save_task)
		_save_task = -1


## Opens the dialog. The scan is given to [param receiver], or a node of its own if there is none. While something is
## under way, the dialog shows that.
func open(receiver: LumivoxVolume3D = null) -> void:
	if not _works():
		_receiver = receiver
		_add_to_scene.text = "Add to Scene" if receiver == null else "Give to %s" % receiver.name
	if _step == Step.CHOOSE:
		_go(Step.CHOOSE)
	elif _step == Step.READY and _thumbnail.texture == null:
		# It was stopped when the dialog was closed.
		_request_picture()
	popup_centered_clamped(Vector2i(Vector2(760.0, 560.0) * EditorInterface.get_editor_scale()), 0.9)
	if _path.text == "":
		_path.grab_focus()


## Opens the dialog and looks at a folder or file, unless something is under way.
func open_path(path: String) -> void:
	open(_receiver if visible else null)
	if _works():
		_add_problem("%s was not opened: one scan at a time. Open it again when this one is done%s." % [
			_name_of(path), "" if _step == Step.SAVING else ", or stopped"])
		return
	_path.text = path
	_raw.text = ""
	_distrust()
	_scan()


## Whether a path is a folder of DICOM files whose names do not say so: Godot's own import would pass them by.
static func holds_unnamed_dicom(path: String, depth := 2) -> bool:
	var folder := DirAccess.open(path)
	if folder == null:
		return false
	for entry in folder.get_files().slice(0, 4):
		if entry.get_extension().to_lower() in ["dcm", "dicom"]:
			return false
		var file := FileAccess.open(path.path_join(entry), FileAccess.READ)
		if file == null or file.get_length() < 132:
			continue
		file.seek(128)
		if file.get_buffer(4).get_string_from_ascii() == "DICM":
			return true
	if depth > 0:
		for entry in folder.get_directories().slice(0, 4):
			if holds_unnamed_dicom(path.path_join(entry), depth - 1):
				return true
	return false


## Whether a path is a zip archive with DICOM in it, by its entries' names.
static func is_dicom_archive(path: String) -> bool:
	var archive := ZIPReader.new()
	if path.get_extension().to_lower() != "zip" or archive.open(path) != OK:
		return false
	for entry in archive.get_files():
		if entry.get_extension().to_lower() in ["dcm", "dicom", "ima"] or entry.get_file().to_upper() == "DICOMDIR":
			return true
	return false


func _source_row() -> Control:
	var row := HBoxContainer.new()
	_path.placeholder_text = "A folder of DICOM files, a zip archive, or a NIfTI, NRRD or MetaImage file"
	_path.size_flags_horizontal = Control.SIZE_EXPAND_FILL
	_path.text_changed.connect(func(_text: String) -> void: _distrust())
	_path.text_submitted.connect(func(_text: String) -> void: _scan())
	row.add_child(_path)
	_browse.text = "Browse..."
	_browse.flat = false
	_browse.get_popup().add_item("Folder...", 0)
	_browse.get_popup().add_item("Archive or File...", 1)
	_browse.get_popup().id_pressed.connect(_on_browse)
	row.add_child(_browse)
	return row


## What a file without a header holds.
func _raw_row() -> Control:
	_raw.placeholder_text = "What the file holds, such as 256x256x108:i16le:spacing=1,1,2"
	_raw.text_submitted.connect(func(_text: String) -> void: _scan())
	_raw.hide()
	return _raw


## For headers that name data files.
func _outside_row() -> Control:
	_allow_outside.text = "Allow data outside the scan's folder"
	_allow_outside.tooltip_text = "Of a header that you trust: its data may be files that lie neither beside it nor below it."
	_allow_outside.toggled.connect(func(_allows: bool) -> void: _scan())
	_allow_outside.hide()
	return _allow_outside


func _series_tree() -> Control:
	_series.columns = COLUMNS.size()
	_series.hide_root = true
	_series.select_mode = Tree.SELECT_ROW
	_series.column_titles_visible = true
	_series.size_flags_vertical = Control.SIZE_EXPAND_FILL
	for i in COLUMNS.size():
		_series.set_column_title(i, COLUMNS[i])
		_series.set_column_title_alignment(i, HORIZONTAL_ALIGNMENT_LEFT)
		_series.set_column_expand_ratio(i, COLUMN_RATIOS[i])
	_series.item_activated.connect(_on_confirmed)
	_series.item_selected.connect(_on_series_selected)
	return _series


## What is known of the series that is selected, and its middle slice.
func _details_row() -> Control:
	var row := HBoxContainer.new()
	row.custom_minimum_size.y = THUMBNAIL_SIZE * EditorInterface.get_editor_scale()
	_thumbnail.custom_minimum_size = Vector2.ONE * row.custom_minimum_size.y
	_thumbnail.expand_mode = TextureRect.EXPAND_IGNORE_SIZE
	_thumbnail.stretch_mode = TextureRect.STRETCH_KEEP_ASPECT_CENTERED
	row.add_child(_thumbnail)
	_details.bbcode_enabled = false
	_details.selection_enabled = true
	_details.size_flags_horizontal = Control.SIZE_EXPAND_FILL
	row.add_child(_details)
	return row


func _target_row() -> Control:
	var row := HBoxContainer.new()
	var label := Label.new()
	label.text = "Save as"
	row.add_child(label)
	_target.size_flags_horizontal = Control.SIZE_EXPAND_FILL
	row.add_child(_target)
	var phase_label := Label.new()
	phase_label.text = "Phase"
	_phase_row.add_child(phase_label)
	_phase.min_value = 1.0
	_phase.tooltip_text = "Which of the volumes in the series is imported."
	_phase_row.add_child(_phase)
	_phase_row.hide()
	row.add_child(_phase_row)
	_keep_everything.text = "Keep Everything"
	_keep_everything.tooltip_text = "Of a CT: the table, clothes and cables too, not the patient alone."
	row.add_child(_keep_everything)
	_add_to_scene.text = "Add to Scene"
	_add_to_scene.tooltip_text = "Shows the scan in the scene that is open, in a LumivoxVolume3D."
	_add_to_scene.button_pressed = true
	row.add_child(_add_to_scene)
	return row


func _progress_row() -> Control:
	var row := HBoxContainer.new()
	_stage.size_flags_horizontal = Control.SIZE_EXPAND_FILL
	_stage.text_overrun_behavior = TextServer.OVERRUN_TRIM_ELLIPSIS
	row.add_child(_stage)
	_progress.size_flags_horizontal = Control.SIZE_EXPAND_FILL
	_progress.size_flags_vertical = Control.SIZE_SHRINK_CENTER
	row.add_child(_progress)
	_stop.text = "Stop"
	_stop.pressed.connect(_stop_work)
	row.add_child(_stop)
	return row


## Whether something is under way.
func _works() -> bool:
	return _step in [Step.SCANNING, Step.IMPORTING, Step.SAVING]


## What a folder or file is called.
static func _name_of(path: String) -> String:
	return path.trim_suffix("/").get_file()


func _go(step: Step) -> void:
	_step = step
	var works := _works()
	_path.editable = not works
	_raw.editable = not works
	_array.set_editable(not works)
	_allow_outside.disabled = works
	_browse.disabled = works
	_target.editable = not works
	_phase.editable = not works
	_keep_everything.disabled = works
	_progress.visible = works
	_stop.visible = step in [Step.SCANNING, Step.IMPORTING]
	_add_to_scene.disabled = works or EditorInterface.get_edited_scene_root() == null
	get_ok_button().disabled = works or step == Step.CHOOSE
	if step == Step.CHOOSE:
		_stage.text = ""


func _on_browse(id: int) -> void:
	if _files == null:
		_files = FileDialog.new()
		_files.access = FileDialog.ACCESS_FILESYSTEM
		_files.use_native_dialog = true
		_files.dir_selected.connect(open_path)
		_files.file_selected.connect(open_path)
		add_child(_files)
	_files.file_mode = FileDialog.FILE_MODE_OPEN_DIR if id == 0 else FileDialog.FILE_MODE_OPEN_FILE
	_files.filters = PackedStringArray() if id == 0 \
			else PackedStringArray(["*.zip,*.nii,*.gz,*.nrrd,*.nhdr,*.mha,*.mhd,*.dcm,*.raw;Scans", "*;All files"])
	_files.popup_centered_clamped(Vector2i(Vector2(800.0, 560.0) * EditorInterface.get_editor_scale()), 0.9)


func _new_importer() -> LumivoxImporter:
	if _importer == null:
		_importer = LumivoxImporter.new()
		_importer.progress.connect(_on_progress)
		_importer.scanned.connect(_on_scanned)
		_importer.finished.connect(_on_finished)
		_importer.failed.connect(_on_failed)
		_importer.cancelled.connect(_on_cancelled)
		_importer.thumbnail_ready.connect(_on_thumbnail_ready)
	return _importer


func _scan() -> void:
	_forget()
	if not DirAccess.dir_exists_absolute(_path.text) and not FileAccess.file_exists(_path.text):
		_show_problem("There is no folder or file '%s'." % _path.text)
		_go(Step.CHOOSE)
		return
	_begin(Step.SCANNING, "Looking at %s" % _name_of(_path.text))
	_raw.visible = _needs_description(_path.text)
	_array.visible = ArrayFields.may_help(_path.text) or not _array.options().is_empty()
	_allow_outside.visible = _path.text.get_extension().to_lower() in ["mhd", "nhdr"]
	var error := _new_importer().scan([_path.text], _source_options())
	if error == ERR_INVALID_PARAMETER and not _array.options().is_empty():
		_on_failed("Spacing, axes or layout is none, as the output says; 0.5,0.5,2, LPS and zyx would be.")
	elif error == ERR_INVALID_PARAMETER:
		_on_failed("'%s' does not describe what a file holds; 256x256x108:i16le:spacing=1,1,2 would." % _raw.text)
	elif error != OK:
		_on_failed(error_string(error))


## Whether a file may say nothing of what it holds.
static func _needs_description(path: String) -> bool:
	return path.get_extension().to_lower() in ["raw", "gz"] and not path.to_lower().ends_with(".nii.gz")


## Trust in one header is none in the next, and what was said of one array not of another.
func _distrust() -> void:
	_allow_outside.set_pressed_no_signal(false)
	_array.clear()


func _source_options() -> Dictionary:
	var options := _array.options()
	if _raw.visible and _raw.text.strip_edges() != "":
		options["raw"] = _raw.text.strip_edges()
	if _allow_outside.visible and _allow_outside.button_pressed:
		options["allow_outside_data"] = true
	return options


func _forget() -> void:
	_report = {}
	_series.clear()
	_target.text = ""
	_suggested = ""
	_details.text = ""
	_thumbnail.texture = null
	_phase_row.hide()


func _begin(step: Step, text: String) -> void:
	_go(step)
	_stage.text = text
	_progress.indeterminate = true


func _on_progress(stage: String, done: int, total: int) -> void:
	_stage.text = stage
	_progress.indeterminate = total <= 0
	_progress.max_value = maxi(total, 1)
	_progress.value = done


func _on_scanned(report: Dictionary) -> void:
	_report = report
	_array.visible = ArrayFields.may_help(_path.text, report.get("format", "") as String)
	var root := _series.create_item()
	var list: Array = report.get("series", [])
	for i in list.size():
		var one: Dictionary = list[i]
		var item := _series.create_item(root)
		item.set_text(0, str(one.number) if one.get("number") != null else "-")
		item.set_text(1, one.get("description", "") as String)
		item.set_tooltip_text(1, one.get("id", "") as String)
		var size: Vector3i = one.get("dimensions", Vector3i.ZERO)
		item.set_text(2, "%d × %d × %d" % [size.x, size.y, size.z])
		item.set_text(3, str(one.get("phases", 1)))
		item.set_text(4, str(one.get("files", 0)))
		var reason: String = one.get("reason", "")
		item.set_text(5, reason)
		item.set_custom_color(5, get_theme_color(&"font_placeholder_color", &"LineEdit"))
		item.set_tooltip_text(5, "Why another series comes first." if reason != "" else "")
		item.set_metadata(0, i)
		if i == (report.get("chosen", 0) as int):
			item.select(0)
	_on_series_selected()
	_stage.text = "%d series" % list.size() if list.size() != 1 else "One series"
	_go(Step.READY)


func _selected_series() -> int:
	var item := _series.get_selected()
	return item.get_metadata(0) as int if item != null else -1


func _on_series_selected() -> void:
	var place := _selected_series()
	_thumbnail.texture = null
	_phase_row.hide()
	if _target.text == _suggested:
		_suggested = _free_name((_report.series as Array)[place].get("name", "") as String if place >= 0 else "")
		_target.text = _suggested
	if place >= 0:
		var phases: int = (_report.series as Array)[place].get("phases", 1)
		_phase.max_value = maxi(phases, 1)
		_phase.value = 1.0
		_phase_row.visible = phases > 1
	_request_picture()
	_show_details()


func _show_details() -> void:
	var place := _selected_series()
	# The same text again would not replace what was added to it.
	_details.text = ""
	_details.text = _series_text((_report.series as Array)[place]) if place >= 0 else ""
	_details.text += _report_text(_report, place)


## Of a large compressed file it takes long; the one that was asked for before is not waited for.
func _request_picture() -> void:
	if _importer != null:
		_importer.request_thumbnail(_selected_series(), THUMBNAIL_SIZE)


func _on_thumbnail_ready(place: int, picture: Image) -> void:
	if picture != null and place == _selected_series():
		_thumbnail.texture = ImageTexture.create_from_image(picture)


func _series_text(one: Dictionary) -> String:
	var spacing: Vector3 = one.get("spacing_mm", Vector3.ZERO)
	var facts: PackedStringArray = [
		one.get("modality", "") as String,
		one.get("orientation", "") as String,
		"voxels of %s × %s × %s mm" % [
			String.num(spacing.x, 3), String.num(spacing.y, 3), String.num(spacing.z, 3)],
		"%s in memory" % String.humanize_size(one.get("bytes", 0) as int),
	]
	if (one.get("unit", "") as String) != "":
		facts.append("values in %s" % one.unit)
	var text := ", ".join(Array(facts).filter(func(fact: String) -> bool: return fact != "")) + "\n"
	if (one.get("reason", "") as String) != "":
		text += "Not the first choice: %s\n" % one.reason
	for note: String in one.get("notes", PackedStringArray()):
		text += "• %s\n" % note
	return text


## Notes of the series that the report is about first, then what was left out, grouped by the reason.
func _report_text(report: Dictionary, place: int) -> String:
	var text := ""
	if place < 0:
		text = "%s without a series that can be imported\n" % report.get("format", "")
	var shown: PackedStringArray = []
	if place == (report.get("chosen", 0) as int):
		shown = (report.series as Array)[place].get("notes", PackedStringArray())
		for note: String in report.get("notes", PackedStringArray()):
			if note not in shown:
				text += "• %s\n" % note
	var reasons: Dictionary[String, PackedStringArray] = {}
	for file: Dictionary in report.get("skipped", []):
		var reason: String = file.reason
		if not reasons.has(reason):
			reasons[reason] = PackedStringArray()
		reasons[reason].append((file.path as String).get_file())
	for reason in reasons:
		var files := reasons[reason]
		var named := ", ".join(files.slice(0, 5)) + (", ..." if files.size() > 5 else "")
		text += "Left out, %s: %d (%s)\n" % [reason, files.size(), named]
	return text


## A path that is free, of what a series is called: folders and archives are often called by the patient's name.
func _free_name(stem: String) -> String:
	var clean := stem.validate_filename().to_snake_case()
	if clean == "":
		clean = "scan"
	var path := "res://%s.res" % clean
	var number := 2
	while FileAccess.file_exists(path):
		path = "res://%s_%d.res" % [clean, number]
		number += 1
	return path


func _on_confirmed() -> void:
	if _step != Step.READY:
		return
	if not _target.text.begins_with("res://") or not _target.text.get_file().is_valid_filename():
		_show_problem("Save the scan inside the project: res://name.res")
		return
	if _target.text.get_extension() != "res":
		_target.text = "%s.res" % _target.text
	var options := _source_options()
	var place := _selected_series()
	if place >= 0 and _report.get("format", "") == "DICOM":
		options["series"] = str(place + 1)
		if _phase_row.visible:
			options["phase"] = int(_phase.value)
	if _keep_everything.button_pressed:
		options["keep_everything"] = true
	_saved_as = _target.text
	_begin(Step.IMPORTING, "Importing")
	var error := _new_importer().start([_path.text], options)
	if error != OK:
		_on_failed(error_string(error))


func _on_finished(volume: LumivoxVolume) -> void:
	_volume = volume
	volume.resource_name = _saved_as.get_file().get_basename()
	_begin(Step.SAVING, "Saving %s" % _saved_as)
	DirAccess.make_dir_recursive_absolute(_saved_as.get_base_dir())
	_save_task = WorkerThreadPool.add_task(_save.bind(volume, _saved_as), false, "Lumivox save")
	set_process(true)


func _save(volume: LumivoxVolume, path: String) -> void:
	_save_result = ResourceSaver.save(volume, path, ResourceSaver.FLAG_COMPRESS)


func _on_saved() -> void:
	if _save_result != OK:
		_show_problem("%s could not be written: %s." % [_saved_as, error_string(_save_result)])
		_go(Step.READY)
		return
	EditorInterface.get_resource_filesystem().scan()
	_volume.take_over_path(_saved_as)
	if _add_to_scene.button_pressed and is_instance_valid(_receiver) and _receiver.is_inside_tree():
		VolumeInspector.give_volume(_undo, _receiver, _volume)
	elif _add_to_scene.button_pressed and EditorInterface.get_edited_scene_root() != null:
		_add_node()
	else:
		EditorInterface.edit_resource(_volume)
	_volume = null
	_path.text = ""
	_forget()
	_importer = null
	_go(Step.CHOOSE)
	hide()


func _add_node() -> void:
	var root := EditorInterface.get_edited_scene_root()
	var node := LumivoxVolume3D.new()
	node.volume = _volume
	node.name = _volume.resource_name.to_pascal_case()
	_undo.create_action("Add Volume", UndoRedo.MERGE_DISABLE, root)
	_undo.add_do_method(root, &"add_child", node, true)
	_undo.add_do_property(node, &"owner", root)
	_undo.add_do_reference(node)
	_undo.add_undo_method(root, &"remove_child", node)
	_undo.commit_action()
	EditorInterface.get_selection().clear()
	EditorInterface.get_selection().add_node(node)


## Stops what is under way, the picture of a series too.
func _stop_work() -> void:
	if _importer != null:
		_importer.cancel()


func _on_cancelled() -> void:
	_go(Step.READY if _step == Step.IMPORTING and not _report.is_empty() else Step.CHOOSE)
	if _step == Step.READY:
		_show_details()
	else:
		_details.text = ""
	_stage.text = "Stopped"


func _on_failed(message: String) -> void:
	_go(Step.READY if _step == Step.IMPORTING and not _report.is_empty() else Step.CHOOSE)
	_show_problem(message)
	if _raw.visible and _raw.text == "":
		_raw.grab_focus()


func _show_problem(message: String) -> void:
	_stage.text = ""
	_details.clear()
	_add_problem(message)


func _add_problem(message: String) -> void:
	if _details.get_parsed_text() != "":
		_details.newline()
	_details.push_color(get_theme_color(&"error_color", &"Editor"))
	_details.add_text(message)
	_details.pop()
