@tool
extends EditorPlugin
## Copies slices into a folder that is imported already, as a slow disk does, and takes some away again. Tells in lines
## `TELL NAME JSON` what each file of the folder is then, and how often the scan was imported for it.

const DicomFolders := preload("res://addons/lumivox/editor/dicom_folders.gd")

const FOLDER := "res://scans/ct"
const PATIENCE_MS := 240_000
## What nothing happened in for so long, and for so many frames, rests.
const REST_MS := 1500
const REST_FRAMES := 30

var _slices := ""
var _imports: Array[String] = []
var _shown: LumivoxVolume


func _enter_tree() -> void:
	var words := OS.get_cmdline_user_args()
	var at := words.find("--slices")
	# Also loaded when the project is imported.
	if at >= 0:
		_slices = words[at + 1]
		EditorInterface.get_resource_filesystem().resources_reimported.connect(func(files: PackedStringArray) -> void:
			_imports.append_array(files))
		_run.call_deferred()


func _run() -> void:
	await _rest()
	_shown = load(FOLDER.path_join("CT0010.dcm"))
	_tell("first")
	# In two steps, between which the editor looks; and while it has the focus, when it does not look by itself.
	_copy(22, 24)
	await _scan()
	await get_tree().create_timer(1.0).timeout
	_copy(25, 28)
	await _rest()
	_tell("more")
	_copy(29, 30)
	await _scan()
	await _rest()
	_tell("last")
	_copy(5, 9)
	await _scan()
	await _rest()
	_tell("earlier")
	DirAccess.remove_absolute(FOLDER.path_join("CT0005.dcm"))
	await _scan()
	await _rest()
	_tell("removed")
	# As large as before, at another time.
	await get_tree().create_timer(1.1).timeout
	_darken(FOLDER.path_join("CT0020.dcm"))
	await _scan()
	await _rest()
	_tell("replaced")
	print("EXPECT an import that fails")
	for name in DirAccess.get_files_at(FOLDER):
		if name.get_extension() == "dcm":
			FileAccess.open(FOLDER.path_join(name), FileAccess.WRITE).store_string("<html>Not found</html>\n")
	await _scan()
	await _rest()
	_tell("broken")
	await _rest()
	_tell("idle")
	# Gone altogether: nothing is said of it.
	for name in DirAccess.get_files_at(FOLDER):
		DirAccess.remove_absolute(FOLDER.path_join(name))
	DirAccess.remove_absolute(FOLDER)
	await _scan()
	await _rest()
	print("GONE")
	get_tree().quit()


## Copies slices from the one number to the other.
func _copy(from: int, to: int) -> void:
	for number in range(from, to + 1):
		var name := "CT%04d.dcm" % number
		DirAccess.copy_absolute(_slices.path_join(name), ProjectSettings.globalize_path(FOLDER.path_join(name)))


## Sets the last values of a slice to the scanner's largest.
func _darken(path: String) -> void:
	var bytes := FileAccess.get_file_as_bytes(path)
	for i in range(bytes.size() - 64, bytes.size(), 2):
		bytes.encode_s16(i, 4095)
	FileAccess.open(path, FileAccess.WRITE).store_buffer(bytes)


## The editor looks for changes, as it does when it gets the focus.
func _scan() -> void:
	var files := EditorInterface.get_resource_filesystem()
	files.scan_sources()
	await get_tree().create_timer(0.5).timeout
	await _idle(files)


## Until neither the editor nor the addon has anything left to do.
func _rest() -> void:
	var files := EditorInterface.get_resource_filesystem()
	var all := get_tree().root.find_children("*", "Node", true, false)
	var folders: Array[Node] = all.filter(func(node: Node) -> bool: return node.get_script() == DicomFolders)
	assert(folders.size() == 1)
	var begin := Time.get_ticks_msec()
	var since := begin
	var frames := 0
	while Time.get_ticks_msec() - begin < PATIENCE_MS:
		await get_tree().process_frame
		frames += 1
		if files.is_scanning() or not (folders[0] as DicomFolders).is_at_rest():
			since = Time.get_ticks_msec()
			frames = 0
		elif frames >= REST_FRAMES and Time.get_ticks_msec() - since >= REST_MS:
			return


func _idle(files: EditorFileSystem) -> void:
	var begin := Time.get_ticks_msec()
	while files.is_scanning() and Time.get_ticks_msec() - begin < PATIENCE_MS:
		await get_tree().process_frame


func _tell(name: String) -> void:
	var told := {"files": {}, "imports": {}, "shown": _shown.get_dimensions().z, "largest": 0.0}
	for file in DirAccess.get_files_at(FOLDER):
		if file.get_extension() != "dcm":
			continue
		var path := FOLDER.path_join(file)
		var volume := load(path) as LumivoxVolume if ResourceLoader.exists(path) and name not in ["broken", "idle"] else null
		if volume == null:
			told.files[file] = null
		elif volume.has_meta(&"lumivox_series"):
			told.files[file] = (volume.get_meta(&"lumivox_series") as String).get_file()
		else:
			told.files[file] = volume.get_dimensions().z
			told.largest = volume.get_value_range().y
	for path in _imports:
		told.imports[path.get_file()] = (told.imports.get(path.get_file(), 0) as int) + 1
	_imports.clear()
	print("TELL %s %s" % [name, JSON.stringify(told)])
